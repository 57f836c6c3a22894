#include "loop_recorder.h"

#include "csv_text.h"
#include "vir/evaluation/trajectory.h"
#include "vir/geometry/finite_pose.h"

namespace vir::results {
namespace {

using namespace csv;

constexpr const char* kHeader =
    "t_newer_s,t_older_s,in_map,accepted,decision,chi2,matches,inliers,x_newer_m,y_newer_m,"
    "z_newer_m,x_older_m,y_older_m,z_older_m,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad";

std::string columns(const Vec3& v) {
  return "," + csvNumber(v.x()) + "," + csvNumber(v.y()) + "," + csvNumber(v.z());
}

std::string line(const LoopRecord& r) {
  std::string out =
      evaluation::formatSeconds(r.t_newer) + "," + evaluation::formatSeconds(r.t_older);
  out += r.in_map ? ",1" : ",0";
  out += r.accepted ? ",1," : ",0,";
  out += r.decision;
  out += r.chi2 < 0 ? "," : format(",%.3f", clean(r.chi2));
  out += format(",%d,%d", r.matches, r.inliers);
  return out + columns(r.p_newer) + columns(r.p_older) + columns(r.T_older_newer.p) +
         columns(logQuat(r.T_older_newer.q));
}

}  // namespace

void LoopRecorder::add(const StampedPose& pose) {
  if (!isFinite(pose.T_W_B)) return;
  if (odometry_ && pose.t <= last_) return;
  if (!odometry_) odometry_.emplace(folder_.file("trajectory_odom.tum"));
  odometry_->line(evaluation::tumLine(pose));
  last_ = pose.t;
}

std::optional<std::pair<long, long>> LoopRecorder::finish(
    const std::optional<std::vector<LoopRecord>>& loops) {
  if (odometry_) odometry_->close();
  if (!loops) return std::nullopt;
  records_ = *loops;
  OutputFile file(folder_.file("loops.csv"));
  file.line(kHeader);
  std::pair<long, long> counts{0, 0};
  for (const LoopRecord& r : *loops) {
    file.line(line(r));
    ++(r.accepted ? counts.first : counts.second);
  }
  file.close();
  return counts;
}

}  // namespace vir::results
