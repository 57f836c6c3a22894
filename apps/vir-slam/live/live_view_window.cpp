/// What `record --view` and `view` draw; see openLiveView().

#include <mrpt/gui/CDisplayWindow3D.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/opengl/CEllipsoid3D.h>
#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/COpenGLViewport.h>
#include <mrpt/opengl/CPointCloud.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/stock_objects.h>

#include <atomic>
#include <cctype>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "live/live_view.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/results/advice.h"

namespace vir::app {
namespace {

using mrpt::opengl::COpenGLScene;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kBetweenFrames = std::chrono::milliseconds(100);
constexpr int kMapEvery = 10;  // keyframes between two looks at the map points and past keyframes

mrpt::img::TColorf blue() { return {0.35f, 0.7f, 0.9f, 1.f}; }
mrpt::img::TColorf green() { return {0.f, 0.62f, 0.45f, 1.f}; }
mrpt::img::TColorf pink() { return {0.95f, 0.35f, 0.75f, 1.f}; }
mrpt::img::TColorf grey() { return {0.5f, 0.5f, 0.45f, 1.f}; }
mrpt::img::TColorf orange() { return {0.9f, 0.6f, 0.f, 1.f}; }

mrpt::opengl::TFontParams font() {
  mrpt::opengl::TFontParams out;
  out.vfont_name = "sans";
  out.vfont_scale = 11;
  out.draw_shadow = true;
  return out;
}

/// The last range of each anchor.
struct RangeNow {
  double metres = 0;
};

/// The window and what is in it.
struct Scene {
  mrpt::gui::CDisplayWindow3D window{"vir-slam", 1100, 750};
  mrpt::opengl::CSetOfLines::Ptr path = mrpt::opengl::CSetOfLines::Create();
  mrpt::opengl::CSetOfLines::Ptr keyframe_path = mrpt::opengl::CSetOfLines::Create();
  mrpt::opengl::CSetOfLines::Ptr loops = mrpt::opengl::CSetOfLines::Create();
  mrpt::opengl::CSetOfLines::Ptr refused = mrpt::opengl::CSetOfLines::Create();
  mrpt::opengl::CPointCloud::Ptr points = mrpt::opengl::CPointCloud::Create();
  mrpt::opengl::CSetOfObjects::Ptr robot = mrpt::opengl::stock_objects::CornerXYZSimple(0.4f, 2);
  mrpt::opengl::CSetOfObjects::Ptr anchors = mrpt::opengl::CSetOfObjects::Create();
  mrpt::opengl::COpenGLViewport::Ptr image_view;

  std::mutex mutex;
  std::vector<StateEstimate> estimates;  // not drawn yet
  std::vector<Anchor> anchor_estimates;
  std::vector<Landmark> landmarks;
  std::vector<LoopRecord> second_visits;
  std::vector<Eigen::Vector2f> pixels;
  std::shared_ptr<const mrpt::obs::CObservationImage> image;
  std::map<std::uint64_t, RangeNow> ranges;
  std::map<TimeNs, Vec3> keyframe_positions;  // in W, as they were last told of
  bool new_map = false, new_keyframes = false;
  StateEstimate newest;
  std::atomic<bool> closed{false};
  int keyframes = 0, segment = 0;
  SteadyClock::time_point last_draw;
  std::optional<Vec3> last_p;

  Scene() {
    auto scene = COpenGLScene::Create();
    scene->insert(mrpt::opengl::CGridPlaneXY::Create(-50, 50, -50, 50, 0, 1));
    auto origin = mrpt::opengl::stock_objects::CornerXYZSimple(0.6f, 3);
    origin->setName("W");
    origin->enableShowName();
    scene->insert(origin);
    path->setColor(blue());
    path->setLineWidth(2.5f);
    keyframe_path->setColor(green());
    keyframe_path->setLineWidth(1.5f);
    loops->setColor(pink());
    loops->setLineWidth(1.5f);
    refused->setColor(grey());
    points->setColor(mrpt::img::TColorf(0.75f, 0.75f, 0.75f, 1.f));
    points->setPointSize(3.f);
    for (const mrpt::opengl::CRenderizable::Ptr& object :
         std::initializer_list<mrpt::opengl::CRenderizable::Ptr>{path, keyframe_path, refused,
                                                                 loops, points, robot, anchors}) {
      scene->insert(object);
    }
    mrpt::opengl::COpenGLScene::Ptr& shown = window.get3DSceneAndLock();
    shown = scene;
    image_view = shown->createViewport("image");
    image_view->setViewportPosition(0.02, 0.02, 0.34, 0.34);
    window.unlockAccess3DScene();
    window.setCameraZoom(20);
    window.setCameraElevationDeg(45);
  }

  void drawPath() {
    for (const StateEstimate& e : estimates) {
      if (!e.valid) continue;
      const Vec3& p = e.state.T_W_B.p;
      const bool joined = last_p && e.segment == segment;
      if (joined) path->appendLine(last_p->x(), last_p->y(), last_p->z(), p.x(), p.y(), p.z());
      last_p = p;
      segment = e.segment;
      robot->setPose(rawlog::toMrptPose(e.state.T_W_B));
    }
    estimates.clear();
    if (last_p) {
      window.setCameraPointingToPoint(static_cast<float>(last_p->x()),
                                      static_cast<float>(last_p->y()),
                                      static_cast<float>(last_p->z()));
    }
  }

  /// What the colours and lengths are, and in words how it goes and what would help.
  void drawWords() {
    window.addTextMessage(8, -20, "grid 1 m; W: world, z up, where it started", 0, font());
    window.addTextMessage(8, -36, "blue: path as known at the time; green: keyframes as known now",
                          1, font());
    if (!second_visits.empty()) {
      window.addTextMessage(8, -68, "pink: places seen twice; grey: such as were refused", 5,
                            font());
    }
    window.addTextMessage(8, -52, "orange: anchors, two standard deviations, and the last range", 2,
                          font());
    const std::string advice = results::adviceFor(newest);
    window.addTextMessage(0.38, 24, healthText(newest) + (advice.empty() ? "" : ": " + advice), 3,
                          font());
    const bool ranging = !anchor_estimates.empty() || !ranges.empty();
    window.addTextMessage(0.38, 8, ranging ? results::adviceFor(anchor_estimates) : "", 4, font());
  }

  /// The states of before move when the window slides on, a loop closes or an anchor is found.
  void drawKeyframes() {
    if (!new_keyframes) return;
    new_keyframes = false;
    keyframe_path->clear();
    const Vec3* before = nullptr;
    for (const auto& [t, p] : keyframe_positions) {
      if (before) {
        keyframe_path->appendLine(before->x(), before->y(), before->z(), p.x(), p.y(), p.z());
      }
      before = &p;
    }
  }

  void setKeyframes(const std::vector<StampedPose>& told) {
    for (const StampedPose& k : told) {
      if (k.T_W_B.p.allFinite()) keyframe_positions[k.t] = k.T_W_B.p;
    }
    new_keyframes = true;
  }

  void drawLoops() {
    loops->clear();
    refused->clear();
    for (const LoopRecord& l : second_visits) {
      const Vec3 &a = l.p_older, &b = l.p_newer;
      if (!a.allFinite() || !b.allFinite()) continue;
      (l.accepted ? loops : refused)->appendLine(a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
    }
  }

  void drawAnchors() {
    anchors->clear();
    for (const Anchor& a : anchor_estimates) {
      if (!a.has_position || !a.p_W.allFinite() || !a.covariance.allFinite()) continue;
      auto ellipsoid = mrpt::opengl::CEllipsoid3D::Create();
      const Mat3 least = Mat3::Identity() * 1e-4;
      ellipsoid->setCovMatrix(mrpt::math::CMatrixDouble33(Mat3(a.covariance + least)));
      ellipsoid->setQuantiles(2.f);
      ellipsoid->setLocation(a.p_W.x(), a.p_W.y(), a.p_W.z());
      ellipsoid->setColor(orange());
      ellipsoid->enableShowName();
      std::string label = "anchor " + std::to_string(a.id);
      const auto range = ranges.find(a.id);
      if (range != ranges.end()) {
        label += "  " + std::to_string(range->second.metres).substr(0, 5) + " m";
      }
      ellipsoid->setName(label);
      anchors->insert(ellipsoid);
      if (range == ranges.end() || !last_p) continue;
      auto beam = mrpt::opengl::CSetOfLines::Create();
      beam->setColor(orange());
      beam->appendLine(last_p->x(), last_p->y(), last_p->z(), a.p_W.x(), a.p_W.y(), a.p_W.z());
      anchors->insert(beam);
    }
  }

  void drawMap() {
    if (!new_map) return;
    new_map = false;
    drawLoops();
    points->clear();
    for (const Landmark& l : landmarks) {
      if (l.p_W.allFinite()) {
        const Eigen::Vector3f p = l.p_W.cast<float>();
        points->insertPoint(p.x(), p.y(), p.z());
      }
    }
  }

  void drawImage() {
    if (!image) return;
    mrpt::img::CImage shown =
        image->image.isColor() ? image->image.makeDeepCopy() : image->image.colorImage();
    for (const Eigen::Vector2f& px : pixels) {
      shown.drawCircle(static_cast<int>(px.x()), static_cast<int>(px.y()), 4,
                       mrpt::img::TColor(0, 220, 90));
    }
    image_view->setImageView(std::move(shown));
    image.reset();
  }
};

class LiveViewWindow final : public LiveView {
 public:
  void setEstimate(const StateEstimate& estimate, const roles::Estimator& estimator) override;
  void setRevision(const Revision& revision) override;
  void setObservation(const mrpt::obs::CObservation::Ptr& observation) override;
  void draw() override;
  bool closed() const override { return !scene_.window.isOpen(); }
  char typed() override {
    if (!scene_.window.keyHit()) return 0;
    const int key = scene_.window.getPushedKey();
    if (key <= 0 || key >= 128) return 0;
    if (key == '=') return '+';                   // the key without shift
    return static_cast<char>(std::tolower(key));  // letters come as their key's capital
  }

 private:
  mutable Scene scene_;
};

void LiveViewWindow::setEstimate(const StateEstimate& estimate, const roles::Estimator& estimator) {
  if (scene_.closed) return;
  const std::lock_guard<std::mutex> lock(scene_.mutex);
  scene_.estimates.push_back(estimate);
  scene_.newest = estimate;
  scene_.anchor_estimates = estimator.anchors();
  scene_.pixels = estimator.trackedPixels();
  if (!estimate.keyframe || ++scene_.keyframes % kMapEvery != 0) return;
  scene_.landmarks = estimator.landmarks();
  scene_.second_visits = estimator.loops().value_or(std::vector<LoopRecord>());
  scene_.new_map = true;
  scene_.setKeyframes(estimator.keyframes());
}

void LiveViewWindow::setRevision(const Revision& revision) {
  const std::lock_guard<std::mutex> lock(scene_.mutex);
  scene_.setKeyframes(revision.keyframes);
}

void LiveViewWindow::setObservation(const mrpt::obs::CObservation::Ptr& observation) {
  const std::lock_guard<std::mutex> lock(scene_.mutex);
  if (auto image = std::dynamic_pointer_cast<const mrpt::obs::CObservationImage>(observation)) {
    // Of a rig's cameras the first.
    const bool further = scene_.image && image->sensorLabel > scene_.image->sensorLabel;
    if (!further) scene_.image = image;
  } else if (auto range = std::dynamic_pointer_cast<const mrpt::obs::CObservationBeaconRanges>(
                 observation)) {
    if (range->sensorLabel == rawlog::kPeerLabel) return;
    for (const auto& r : range->sensedData) {
      scene_.ranges[static_cast<std::uint64_t>(r.beaconID)] = {r.sensedDistance};
    }
  }
}

void LiveViewWindow::draw() {
  const auto now = SteadyClock::now();
  if (now - scene_.last_draw < kBetweenFrames) return;
  scene_.closed = closed();
  if (scene_.closed) return;
  scene_.last_draw = now;
  scene_.window.get3DSceneAndLock();
  {
    const std::lock_guard<std::mutex> lock(scene_.mutex);
    scene_.drawPath();
    scene_.drawKeyframes();
    scene_.drawAnchors();
    scene_.drawMap();
    scene_.drawImage();
    scene_.drawWords();
  }
  scene_.window.unlockAccess3DScene();
  scene_.window.forceRepaint();
}

}  // namespace
}  // namespace vir::app

extern "C" __attribute__((visibility("default"))) vir::app::LiveView* virOpenLiveView() {
  return new vir::app::LiveViewWindow();
}
