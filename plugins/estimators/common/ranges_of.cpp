#include "ranges_of.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "vir/rawlog/mrpt_time.h"

namespace vir {
namespace {
constexpr const char* kAnchorPrefix = "ANCHOR:";
}

std::vector<estimator::RangeMeasurement> rangesOf(const mrpt::obs::CObservation& observation) {
  std::vector<estimator::RangeMeasurement> out;
  const auto* o = dynamic_cast<const mrpt::obs::CObservationBeaconRanges*>(&observation);
  if (!o) return out;
  for (const auto& m : o->sensedData) {
    estimator::RangeMeasurement r;
    r.t = rawlog::fromMrptTime(o->timestamp);
    r.anchor = static_cast<std::uint32_t>(m.beaconID);
    r.range_m = static_cast<double>(m.sensedDistance);
    r.sigma_m = static_cast<double>(o->stdError);
    const auto& p = m.sensorLocationOnRobot;
    r.p_B_U = Vec3(p.x(), p.y(), p.z());
    out.push_back(r);
  }
  return out;
}

std::optional<AnchorEvent> anchorEventOf(const mrpt::obs::CObservation& observation) {
  const std::string& label = observation.sensorLabel;
  if (label.rfind(kAnchorPrefix, 0) != 0) return std::nullopt;
  const auto* o = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&observation);
  if (!o) return std::nullopt;
  AnchorEvent event;
  const char* const first = label.data() + std::string(kAnchorPrefix).size();
  const char* const last = label.data() + label.size();
  if (std::from_chars(first, last, event.id).ptr != last || first == last) return std::nullopt;
  const auto& mean = o->pose.mean;
  event.p_B = Vec3(mean.x(), mean.y(), mean.z());
  double variance = 0;
  for (int i = 0; i < 3; ++i) variance = std::max(variance, o->pose.cov(i, i));
  if (variance > 0 && std::isfinite(variance)) event.sigma_m = std::sqrt(variance);
  if (!event.p_B.allFinite()) return std::nullopt;
  return event;
}

void loadBiasModel(estimator::RangeOptions* options) {
  if (options->bias_model_file.empty()) return;
  std::ifstream in(options->bias_model_file);
  if (!in) {
    throw std::runtime_error("[Ranges] bias_model = " + options->bias_model_file +
                             ": cannot be read; give a file of `vir-slam calibrate uwb`");
  }
  std::ostringstream text;
  text << in.rdbuf();
  options->bias_model = ranging::RangeBiasModel::fromText(text.str(), options->bias_model_file);
}

std::vector<roles::AnchorEstimate> toEstimates(
    const std::vector<estimator::AnchorReport>& anchors) {
  std::vector<roles::AnchorEstimate> out;
  for (const estimator::AnchorReport& a : anchors) {
    roles::AnchorEstimate e;
    e.id = a.id;
    e.has_position = a.has_position;
    e.p_W = a.p_W;
    e.covariance = a.covariance;
    e.bias_m = a.bias_m;
    e.bias_sigma_m = a.bias_sigma_m;
    e.state = a.state;
    e.advice = a.advice;
    e.mirror_p_W = a.mirror_p_W;
    e.ranges_used = a.used;
    e.ranges_rejected = a.rejected;
    out.push_back(e);
  }
  return out;
}

std::vector<roles::RangeRecord> toRecords(const std::vector<estimator::RangeDecision>& decisions) {
  std::vector<roles::RangeRecord> out;
  out.reserve(decisions.size());
  for (const estimator::RangeDecision& d : decisions) {
    out.push_back({d.t, d.anchor, d.measured_m, d.predicted_m, d.residual_m, d.sigma_m, d.weight,
                   d.decision});
  }
  return out;
}

}  // namespace vir
