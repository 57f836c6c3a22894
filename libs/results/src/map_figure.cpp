#include <algorithm>

#include "csv_text.h"
#include "run_figures.h"
#include "vir/evaluation/figure_parts.h"

namespace vir::results {
namespace {

const evaluation::Color kTruth{120, 120, 120}, kInk{40, 40, 40};
const evaluation::Color kCausal = evaluation::figureColor(0),
                        kSmoothed = evaluation::figureColor(2),
                        kAnchor = evaluation::figureColor(1);
const evaluation::Color kLoop{200, 60, 160}, kRefused{170, 170, 150};
/// More refused second visits than this would hide the path: every n-th is drawn.
constexpr std::size_t kMostRefused = 300;
constexpr double kSigmas = 2;
/// An anchor this many times as far away as the path is long would make the path a speck.
constexpr double kFarAway = 10;

/// A transform that is none where there is nothing to compare.
Pose toEstimate(const RunPictures& run) {
  return run.evaluation ? run.evaluation->transform.T_R_E.inverse() : Pose();
}

/// The truth while the estimate ran, in the estimate's world; empty if it cannot be laid onto it.
Trajectory alignedTruth(const RunPictures& run) {
  Trajectory aligned;
  if (!run.evaluation || run.causal.empty()) return aligned;
  const Pose T_E_R = toEstimate(run);
  for (const StampedPose& pose : run.truth) {
    if (pose.t < run.causal.front().t || pose.t > run.causal.back().t) continue;
    aligned.push_back({pose.t, T_E_R * pose.T_W_B});
  }
  return aligned;
}

/// Every n-th pose, so that the picture of a long run stays small.
Trajectory thinned(const Trajectory& path) {
  constexpr std::size_t kMost = 3000;
  const std::size_t n = path.size() / kMost + 1;
  Trajectory out;
  for (std::size_t i = 0; i < path.size(); i += n) out.push_back(path[i]);
  return out;
}

struct Box {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  double size() const { return std::max(1.0, (high - low).maxCoeff()); }
};

class Map {
 public:
  explicit Map(const RunPictures& run)
      : run_(run),
        truth_(thinned(alignedTruth(run))),
        causal_(thinned(run.causal)),
        smoothed_(thinned(run.smoothed)) {
    for (const StampedPose& p : run.causal) paths_.add(p.T_W_B.p);
    for (const StampedPose& p : truth_) paths_.add(p.T_W_B.p);
    if (run.causal.empty()) paths_.add(Vec3::Zero());
    all_ = paths_;
    for (const Anchor& a : run.anchors) {
      if (!a.has_position || !a.p_W.allFinite()) continue;
      if (near(a.p_W)) {
        anchors_.push_back(&a);
        all_.add(a.p_W);
        if (hasMirror(a)) all_.add(a.mirror_p_W);
      } else {
        far_.push_back(&a);
      }
    }
  }

  evaluation::Figure figure() const {
    evaluation::Figure figure;
    figure.width = 1200;
    figure.title = "Map";
    figure.subtitle = "in the estimate's world: z up, origin and heading where it began";
    figure.legend = {20, 64};
    figure.entries = legend();
    const double top = 64 + 20 * static_cast<double>(figure.entries.size()) + 40;
    const int side = evaluation::longerHorizontalAxis(run_.causal);
    figure.panels = {panel("From above", 0, 1, {80, top}),
                     panel("From the side", side, 2, {680, top})};
    figure.height = top + 440 + 60;
    return figure;
  }

 private:
  bool near(const Vec3& p) const {
    const Vec3 middle = 0.5 * (paths_.low + paths_.high);
    return (p - middle).norm() < kFarAway * paths_.size();
  }
  bool hasMirror(const Anchor& a) const {
    return a.state == AnchorState::mirror_open && a.mirror_p_W.allFinite() && near(a.mirror_p_W);
  }

  std::vector<evaluation::LegendEntry> legend() const {
    std::vector<evaluation::LegendEntry> entries{
        {"causal trajectory (dot: where it starts)", kCausal}};
    if (!run_.smoothed.empty()) entries.push_back({"keyframes as last seen (smoothed)", kSmoothed});
    if (!truth_.empty()) {
      entries.push_back(
          {"ground truth, laid onto the causal trajectory by position and yaw", kTruth});
    }
    if (hasLoops(true)) entries.push_back({"places seen twice", kLoop});
    if (hasLoops(false)) entries.push_back({"refused", kRefused});
    if (!anchors_.empty()) {
      entries.push_back(
          {"anchors with 2 sigma ellipse (ring: mirror position not yet ruled out; "
           "cross: true position, where known)",
           kAnchor});
    }
    for (const Anchor* a : far_) {
      entries.push_back(
          {"not shown, too far away: anchor " + std::to_string(a->id) +
               csv::format(" at (%.0f, %.0f, %.0f) m", a->p_W.x(), a->p_W.y(), a->p_W.z()),
           kAnchor});
    }
    return entries;
  }

  evaluation::Panel panel(const char* title, int a, int b, const Vec2& corner) const {
    static const char* const labels[] = {"x [m]", "y [m]", "z [m]"};
    evaluation::Panel panel;
    panel.title = title;
    panel.corner = corner;
    panel.size = {490, 440};
    panel.equal_aspect = true;
    panel.x_label = labels[a];
    panel.y_label = labels[b];
    constexpr TimeNs kNeverCut = INT64_MAX;  // keyframes rest where the robot rests
    panel.curves.push_back(
        {kTruth, 3, evaluation::pathStrokes(truth_, a, b, evaluation::holeOf(truth_))});
    panel.curves.push_back(
        {kCausal, 1.5, evaluation::pathStrokes(causal_, a, b, evaluation::holeOf(causal_))});
    panel.curves.push_back({kSmoothed, 1.2, evaluation::pathStrokes(smoothed_, a, b, kNeverCut)});
    addLoops(a, b, &panel);
    if (!run_.causal.empty()) {
      const Vec3& p = run_.causal.front().T_W_B.p;
      panel.marks.push_back({{p[a], p[b]}, kInk, 4, evaluation::Mark::Shape::dot, ""});
    }
    for (const Anchor* anchor : anchors_) addAnchor(*anchor, a, b, &panel);
    addTrueAnchors(a, b, &panel);
    return panel;
  }

  bool hasLoops(bool accepted) const {
    return std::any_of(run_.loops.begin(), run_.loops.end(),
                       [&](const LoopRecord& l) { return l.accepted == accepted; });
  }

  void addLoops(int a, int b, evaluation::Panel* panel) const {
    std::vector<std::vector<Vec2>> accepted, refused;
    for (const LoopRecord& l : run_.loops) {
      (l.accepted ? accepted : refused)
          .push_back({{l.p_older[a], l.p_older[b]}, {l.p_newer[a], l.p_newer[b]}});
      if (l.in_map && l.accepted) {
        panel->marks.push_back(
            {{l.p_older[a], l.p_older[b]}, kLoop, 2, evaluation::Mark::Shape::ring, ""});
      }
    }
    const std::size_t every = refused.size() / kMostRefused + 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < refused.size(); i += every) refused[kept++] = refused[i];
    refused.resize(kept);
    if (!refused.empty()) panel->curves.push_back({kRefused, 0.8, refused});
    if (!accepted.empty()) panel->curves.push_back({kLoop, 1.2, accepted});
  }

  void addAnchor(const Anchor& anchor, int a, int b, evaluation::Panel* panel) const {
    const Vec2 at(anchor.p_W[a], anchor.p_W[b]);
    panel->marks.push_back(
        {at, kAnchor, 4, evaluation::Mark::Shape::dot, std::to_string(anchor.id)});
    addEllipse(at, anchor.covariance, a, b, panel);
    if (!hasMirror(anchor)) return;
    const Vec2 mirror(anchor.mirror_p_W[a], anchor.mirror_p_W[b]);
    panel->marks.push_back(
        {mirror, kAnchor, 5, evaluation::Mark::Shape::ring, std::to_string(anchor.id) + "?"});
  }

  /// The axes reach the ellipse as far as that leaves the rest readable.
  void addEllipse(const Vec2& at, const Mat3& covariance, int a, int b,
                  evaluation::Panel* panel) const {
    Eigen::Matrix2d c;
    c << covariance(a, a), covariance(a, b), covariance(b, a), covariance(b, b);
    const std::vector<Vec2> outline = evaluation::ellipseOutline(at, c, kSigmas);
    const double margin = 0.3 * all_.size();
    const Vec2 low(all_.low[a] - margin, all_.low[b] - margin);
    const Vec2 high(all_.high[a] + margin, all_.high[b] + margin);
    for (const Vec2& p : outline) panel->extent.push_back(p.cwiseMax(low).cwiseMin(high));
    panel->areas.push_back({kAnchor, 0.12, outline});
    panel->curves.push_back({kAnchor, 1, {outline}, false});
  }

  void addTrueAnchors(int a, int b, evaluation::Panel* panel) const {
    if (!run_.evaluation) return;
    for (const auto& [id, p_R] : run_.true_anchors) {
      const Vec3 p = toEstimate(run_) * p_R;
      if (p.allFinite() && near(p))
        panel->marks.push_back({{p[a], p[b]}, kInk, 5, evaluation::Mark::Shape::cross, ""});
    }
  }

  const RunPictures& run_;
  Trajectory truth_, causal_, smoothed_;
  Box paths_, all_;  // of the paths; of the anchors too
  std::vector<const Anchor*> anchors_, far_;
};

}  // namespace

evaluation::Figure mapFigure(const RunPictures& run) { return Map(run).figure(); }

}  // namespace vir::results
