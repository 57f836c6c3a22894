#pragma once
/// Where simulated robots truly are, and their worlds.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "end_to_end.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_rawlog.h"

namespace vir::test {

inline nlohmann::json readJson(const std::filesystem::path& path) {
  return nlohmann::json::parse(readText(path));
}

inline Trajectory truthIn(const std::string& rawlog) {
  Trajectory out;
  rawlog::RawlogReader reader(rawlog);
  while (const auto o = reader.next()) {
    const auto pose = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(o);
    if (!pose || pose->sensorLabel != "GT") continue;
    const TimeNs t = rawlog::fromMrptTime(pose->timestamp);
    if (out.empty() || t > out.back().t) out.push_back({t, rawlog::fromMrptPose(pose->pose.mean)});
  }
  return out;
}

/// The world in which a simulated robot tells its positions begins at its first pose, z up.
inline Pose toldWorld(const std::string& rawlog) {
  const Pose first = truthIn(rawlog).front().T_W_B;
  return {Quat(rotZ(yawOf(first.R()))), first.p};
}

struct Deviation {
  double offset_m = 0, yaw_deg = 0;
};

/// Of an entry of transforms.json from the transform between two worlds.
inline Deviation deviation(const nlohmann::json& transform, const Pose& wanted) {
  const auto& t = transform["t_m"];
  const Vec3 offset(t[0].get<double>(), t[1].get<double>(), t[2].get<double>());
  const double yaw = transform["yaw_rad"].get<double>() - yawOf(wanted.R());
  return {(offset - wanted.p).norm(), std::abs(std::remainder(yaw, 2 * M_PI)) * 180 / M_PI};
}

/// Takes an estimate's world to that of the truth.
inline Pose worldOf(const Trajectory& truth, const Trajectory& estimate) {
  return evaluation::evaluate(truth, estimate, evaluation::EvaluationOptions{}).transform.T_R_E;
}

}  // namespace vir::test
