#pragma once
/// The streams of a recording, each a file read in time order.
#include <memory>
#include <string>
#include <vector>

#include "problem_log.h"
#include "row_cursor.h"
#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir::euroc {

struct ImuRow {
  TimeNs t = 0;
  Vec3 gyro = Vec3::Zero();  ///< [rad/s], IMU frame
  Vec3 acc = Vec3::Zero();   ///< specific force [m/s^2], IMU frame
};

struct ImageRow {
  TimeNs t = 0;
  std::string file;  ///< name as listed
};

struct RangeRow {
  TimeNs t = 0;
  int anchor = 0;
  double range_m = 0;
};

struct PoseRow {
  TimeNs t = 0;
  Pose T_W_B;  ///< body of the recording in the ground truth's world
};

/// Where an anchor truly is.
struct AnchorRow {
  int id = 0;
  Vec3 p_W = Vec3::Zero();  ///< [m], in the ground truth's world
};

/// `#timestamp [ns], gyro xyz, acc xyz`.
std::unique_ptr<RowCursor<ImuRow>> openImu(const std::string& path, ProblemLog* log);
/// `#timestamp [ns], filename`.
std::unique_ptr<RowCursor<ImageRow>> openImageList(const std::string& path, ProblemLog* log);
/// `#timestamp [ns], anchor_id, range [m]`, further columns ignored.
std::unique_ptr<RowCursor<RangeRow>> openRanges(const std::string& path, ProblemLog* log);
/// `#timestamp [ns], p xyz, q wxyz`, further columns ignored.
std::unique_ptr<RowCursor<PoseRow>> openGroundTruthCsv(const std::string& path, ProblemLog* log);
/// `timestamp(s) x y z qx qy qz qw`.
std::unique_ptr<RowCursor<PoseRow>> openGroundTruthTum(const std::string& path, ProblemLog* log);
/// `#id, x, y, z`. Throws InputError if the file cannot be opened.
std::vector<AnchorRow> readAnchorTable(const std::string& path, ProblemLog* log);

}  // namespace vir::euroc
