#include "report_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "json_columns.h"
#include "page_frame.h"
#include "vir/core/angles.h"
#include "vir/evaluation/nees.h"

namespace vir::results {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
std::string text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

class Writer {
 public:
  Writer(const RunSummary& summary, const ReportData& data)
      : s_(summary), d_(data), run_(data.pictures) {}

  std::string json() {
    std::string out = "{\"version\":" + text(VIR_VERSION);
    out += ",\"frames\":" + frames();
    out += ",\"error_frame\":" +
           text("in the estimate's world as it began: the frame of the band, 3 sigma");
    out += ",\"truth\":" + pathJson(alignedTruth(), run_.first_frame);
    out += ",\"smoothed\":" + pathJson(thinnedForPage(run_.smoothed), run_.first_frame);
    out += ",\"anchors\":" + anchors() + ",\"landmarks\":" + pointsJson(d_.landmarks);
    out += ",\"loops\":" + loops(true) + ",\"loops_refused\":" + loops(false);
    out += ",\"ranges\":" + ranges() + ",\"decisions\":" + decisions();
    out += ",\"calibration\":" + calibration() + ",\"calibration_groups\":" + groups();
    out += ",\"events\":" + events() + ",\"images\":" + images() + "}";
    return out;
  }

 private:
  double seconds(TimeNs t) const { return toSeconds(t - run_.first_frame); }
  const std::vector<FrameSample>& samples() const { return d_.history.samples(); }

  /// Where the camera looks, or else the body's x, seen from above.
  double heading(const FrameSample& f) const {
    const bool camera = s_.calibration && s_.calibration->camera.fx > 0;
    const Vec3 ahead = camera ? Vec3(s_.calibration->T_B_C.q * Vec3::UnitZ()) : Vec3::UnitX();
    const Vec3 a = f.state.T_W_B.q * ahead;
    return kDegPerRad * std::atan2(a.y(), a.x());
  }

  std::string frames() {
    std::string out = "{";
    const std::vector<FrameSample>& f = samples();
    const auto add = [&](const char* name, int decimals, auto value) {
      addColumn(
          name, f.size(), decimals,
          [&](std::size_t i) { return f[i].valid ? static_cast<double>(value(f[i])) : kUnknown; },
          &out);
    };
    const auto triple = [&](std::initializer_list<const char*> names, int decimals, auto vector) {
      int axis = 0;
      for (const char* name : names) {
        add(name, decimals, [&](const FrameSample& s) { return vector(s)[axis]; });
        ++axis;
      }
    };
    addColumn(
        "t", f.size(), 3, [&](std::size_t i) { return seconds(f[i].t); }, &out);
    triple({"x", "y", "z"}, 3, [](const FrameSample& s) { return s.state.T_W_B.p; });
    triple({"vx", "vy", "vz"}, 3, [](const FrameSample& s) { return s.state.v; });
    triple({"bgx", "bgy", "bgz"}, 5, [](const FrameSample& s) { return s.state.bg; });
    triple({"bax", "bay", "baz"}, 4, [](const FrameSample& s) { return s.state.ba; });
    triple({"sx", "sy", "sz"}, 4, [](const FrameSample& s) { return s.sigma_p; });
    triple({"srx", "sry", "srz"}, 3,
           [](const FrameSample& s) { return Vec3(kDegPerRad * s.sigma_r); });
    add("heading", 0, [&](const FrameSample& s) { return heading(s); });
    addAttitude(&out);
    addErrors(&out);
    add("reprojection", 2, [](const FrameSample& s) { return s.reprojection_rms; });
    add("inertial", 2, [](const FrameSample& s) { return s.inertial_rms; });
    addColumn(
        "tracks", f.size(), 0, [&](std::size_t i) { return f[i].tracks; }, &out);
    addColumn(
        "landmarks", f.size(), 0, [&](std::size_t i) { return f[i].landmarks; }, &out);
    addColumn(
        "ms", f.size(), 1, [&](std::size_t i) { return f[i].ms; }, &out);
    return out + "}";
  }

  /// Yaw and roll go on beyond half a turn, so that curves have no jumps.
  void addAttitude(std::string* out) const {
    const std::vector<FrameSample>& f = samples();
    std::vector<Vec3> angles;
    Vec3 last = Vec3::Zero();
    for (const FrameSample& s : f) {
      const Mat3 R = s.state.T_W_B.R();
      Vec3 a(std::atan2(R(1, 0), R(0, 0)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
             std::atan2(R(2, 1), R(2, 2)));
      for (const int i : {0, 2}) a[i] += 2 * kPi * std::round((last[i] - a[i]) / (2 * kPi));
      if (s.valid && a.allFinite()) last = a;
      angles.push_back(s.valid ? Vec3(kDegPerRad * a) : Vec3::Constant(kUnknown));
    }
    int axis = 0;
    for (const char* name : {"yaw", "pitch", "roll"}) {
      addColumn(
          name, f.size(), 1, [&](std::size_t i) { return angles[i][axis]; }, out);
      ++axis;
    }
  }

  void addErrors(std::string* out) const {
    if (d_.errors.empty()) return;
    const std::vector<FrameSample>& f = samples();
    std::vector<Vec3> p(f.size(), Vec3::Constant(kUnknown)), r = p;
    std::size_t at = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      while (at < d_.errors.size() && d_.errors[at].t < f[i].t) ++at;
      if (at == d_.errors.size() || d_.errors[at].t != f[i].t) continue;
      p[i] = d_.errors[at].p;
      r[i] = kDegPerRad * d_.errors[at].r;
    }
    int axis = 0;
    for (const char* name : {"x", "y", "z"}) {
      const std::string axis_name = name;
      addColumn(("e" + axis_name).c_str(), f.size(), 4, [&](std::size_t i) { return p[i][axis]; },
                out);
      addColumn(("er" + axis_name).c_str(), f.size(), 3, [&](std::size_t i) { return r[i][axis]; },
                out);
      ++axis;
    }
  }

  Pose toEstimate() const {
    return run_.evaluation ? run_.evaluation->transform.T_R_E.inverse() : Pose();
  }

  Trajectory alignedTruth() const {
    Trajectory out;
    if (!run_.evaluation || run_.causal.empty()) return out;
    const Pose T_E_R = toEstimate();
    for (const StampedPose& pose : run_.truth) {
      if (pose.t < run_.causal.front().t || pose.t > run_.causal.back().t) continue;
      out.push_back({pose.t, T_E_R * pose.T_W_B});
    }
    return thinnedForPage(out);
  }

  std::string anchors() const {
    std::string out = "[";
    for (const Anchor& a : run_.anchors) {
      const auto truth = run_.true_anchors.find(a.id);
      const bool told = run_.evaluation && truth != run_.true_anchors.end();
      const Vec3 p = told ? Vec3(toEstimate() * truth->second) : Vec3::Zero();
      out += (out.size() > 1 ? "," : "") + anchorJson(a, told ? &p : nullptr);
    }
    return out + "]";
  }

  /// As one path each, from the place seen again to that seen first, with nothing between two.
  std::string loops(bool accepted) const {
    std::vector<LoopRecord> all;
    for (const LoopRecord& l : run_.loops) {
      if (l.accepted == accepted) all.push_back(l);
    }
    all = thinnedForPage(all);
    std::string out = "{";
    int axis = 0;
    for (const char* name : {"x", "y", "z"}) {
      addColumn(
          name, 3 * all.size(), 3,
          [&](std::size_t i) {
            const LoopRecord& l = all[i / 3];
            return i % 3 == 0 ? l.p_newer[axis] : i % 3 == 1 ? l.p_older[axis] : kUnknown;
          },
          &out);
      ++axis;
    }
    return out + "}";
  }

  std::string ranges() const {
    const std::vector<RangeRecord>& r = run_.ranges;
    std::string out = "{";
    const auto predicted = [&](std::size_t i) { return r[i].sigma_m > 0 || r[i].predicted_m != 0; };
    addColumn(
        "t", r.size(), 2, [&](std::size_t i) { return seconds(r[i].t); }, &out);
    addColumn(
        "id", r.size(), 0, [&](std::size_t i) { return static_cast<double>(r[i].anchor); }, &out);
    addColumn(
        "residual", r.size(), 3,
        [&](std::size_t i) { return predicted(i) ? r[i].residual_m : kUnknown; }, &out);
    addColumn(
        "sigma", r.size(), 3, [&](std::size_t i) { return r[i].sigma_m; }, &out);
    addColumn(
        "decision", r.size(), 0, [&](std::size_t i) { return static_cast<double>(r[i].decision); },
        &out);
    return out + "}";
  }

  static std::string decisions() {
    Json names = Json::array();
    for (int d = 0; d <= static_cast<int>(RangeDecision::before_the_start); ++d) {
      names.push_back(name(static_cast<RangeDecision>(d)));
    }
    return text(names);
  }

  std::string calibration() const {
    const std::vector<roles::CalibrationPoint> k = thinnedForPage(run_.calibrations);
    std::string out = "{";
    addColumn(
        "t", k.size(), 2, [&](std::size_t i) { return seconds(k[i].t); }, &out);
    if (k.empty()) return out + "}";
    const Calibration given = run_.calibration_given.value_or(k.front().calibration);
    const auto add = [&](const char* name, int decimals, auto value) {
      addColumn(
          name, k.size(), decimals, [&](std::size_t i) { return value(k[i].calibration); }, &out);
    };
    add("offset", 3,
        [&](const Calibration& c) { return 1e3 * (c.time_offset_s - given.time_offset_s); });
    add("fx", 2, [&](const Calibration& c) { return c.camera.fx - given.camera.fx; });
    add("fy", 2, [&](const Calibration& c) { return c.camera.fy - given.camera.fy; });
    add("cx", 2, [&](const Calibration& c) { return c.camera.cx - given.camera.cx; });
    add("cy", 2, [&](const Calibration& c) { return c.camera.cy - given.camera.cy; });
    static constexpr const char* kRotation[] = {"rx", "ry", "rz"};
    static constexpr const char* kPosition[] = {"px", "py", "pz"};
    for (int axis = 0; axis < 3; ++axis) {
      add(kRotation[axis], 3, [&](const Calibration& c) {
        return kDegPerRad * logQuat(given.T_B_C.q.conjugate() * c.T_B_C.q)[axis];
      });
      add(kPosition[axis], 2,
          [&](const Calibration& c) { return 1e3 * (c.T_B_C.p - given.T_B_C.p)[axis]; });
    }
    return out + ",\"sigma\":" + calibrationSigma(k) + "}";
  }

  static std::string calibrationSigma(const std::vector<roles::CalibrationPoint>& k) {
    std::string out = "{";
    const auto add = [&](const char* name, int decimals, auto value) {
      addColumn(
          name, k.size(), decimals, [&](std::size_t i) { return value(k[i]); }, &out);
    };
    using Point = roles::CalibrationPoint;
    add("offset", 3, [](const Point& p) { return 1e3 * p.sigma.time_offset_s; });
    add("focal", 2, [](const Point& p) { return p.calibration.camera.fx * p.sigma.focal; });
    add("centre", 2, [](const Point& p) { return p.sigma.centre_px; });
    add("rotation", 3, [](const Point& p) { return kDegPerRad * p.sigma.rotation_rad; });
    add("position", 2, [](const Point& p) { return 1e3 * p.sigma.position_m; });
    return out + "}";
  }

  /// Charts of the calibration; `sigma` names a column of it.
  static std::string groups() {
    const auto group = [](const char* name, const char* unit, const char* sigma,
                          const std::vector<std::string>& keys) {
      return Json{{"name", name}, {"unit", unit}, {"sigma", sigma}, {"keys", keys}};
    };
    return text(Json::array({group("time offset", "ms", "offset", {"offset"}),
                             group("focal lengths", "px", "focal", {"fx", "fy"}),
                             group("principal point", "px", "centre", {"cx", "cy"}),
                             group("rotation", "deg", "rotation", {"rx", "ry", "rz"}),
                             group("position", "mm", "position", {"px", "py", "pz"})}));
  }

  std::string events() const {
    std::string out = "[";
    for (const FrameEvent& e : d_.history.events()) {
      if (out.size() > 1) out += ",";
      out +=
          "[" + jsonNumber(seconds(e.t), 2) + "," + text(e.text) + (e.bad ? ",true]" : ",false]");
    }
    return out + "]";
  }

  std::string images() const {
    std::string out = "[";
    for (const Thumbnail& i : d_.images) {
      if (out.size() > 1) out += ",";
      out += "{\"t\":" + jsonNumber(seconds(i.t), 2) + ",\"w\":" + std::to_string(i.width) +
             ",\"h\":" + std::to_string(i.height) + ",\"why\":" + text(i.why) + ",\"tracks\":[";
      for (std::size_t k = 0; k < i.tracked.size(); ++k) {
        out += (k > 0 ? "," : "") + jsonNumber(i.tracked[k].x(), 0) + "," +
               jsonNumber(i.tracked[k].y(), 0);
      }
      out += "],\"src\":\"data:image/jpeg;base64," + base64(i.jpeg) + "\"}";
    }
    return out + "]";
  }

  static std::string base64(const std::vector<unsigned char>& bytes) {
    static constexpr char kDigits[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
      unsigned word = 0;
      for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
      for (std::size_t k = 0; k < 4; ++k) {
        out += k <= left ? kDigits[word >> (18 - 6 * k) & 63] : '=';
      }
    }
    return out;
  }

  const RunSummary& s_;
  const ReportData& d_;
  const RunPictures& run_;
};

}  // namespace

std::optional<Pose> worldAtStart(const Trajectory& truth, const StampedPose& start) {
  const evaluation::Association first = evaluation::associate(truth, {start}, {});
  if (first.pairs.empty()) return std::nullopt;
  return evaluation::gaugeAt(first.pairs.front().reference, first.pairs.front().estimate).inverse();
}

std::string reportJson(const RunSummary& summary, const ReportData& data) {
  return insideScript(Writer(summary, data).json());
}

}  // namespace vir::results
