#pragma once
/// The streams of a recording, each a file read in time order.
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "problem_log.h"
#include "row_cursor.h"
#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/tables/anchor_names.h"
#include "vir/types/imu_sample.h"

namespace vir::euroc {

/// A reading of a gyro or of an accelerometer alone.
struct VectorRow {
  TimeNs t = 0;
  Vec3 v = Vec3::Zero();  ///< [rad/s] or [m/s^2]
};

struct ImageRow {
  TimeNs t = 0;
  std::string file;  ///< name as listed
  cv::Mat pixels;    ///< of a frame of a video, which has no file of its own; empty: in `file`
};

struct RangeRow {
  TimeNs t = 0;
  int anchor = 0;
  double range_m = 0;
  std::string antenna;                    ///< empty: not said
  std::optional<Vec3> place;              ///< of the antenna, in our body [m]; none: not said
  double sigma_m = 0;                     ///< standard deviation; 0: not said
  std::optional<Vec3> anchor_place = {};  ///< in a frame of its own [m]; none: not said
  std::optional<int> reference = {};      ///< a difference of ranges: less that to this anchor
  std::optional<int> from = {};           ///< the anchor that measured it; none: the robot did
};

struct PoseRow {
  TimeNs t = 0;
  Pose T_W_B;                ///< body of the recording in the ground truth's world
  bool has_attitude = true;  ///< false: a position only, T_W_B.q is the identity
};

/// Where an anchor truly is.
struct AnchorRow {
  int id = 0;
  Vec3 p_W = Vec3::Zero();  ///< [m], in the ground truth's world
};

/// Every reader takes columns by the names of a header (vir/tables/layout.h), any separator, and
/// stamps in the unit that they can only be in; what is not as EuRoC has it is noted in the log.

/// What the numbers are multiplied by; 0: as the header says, else SI.
struct Units {
  double gyro = 0;          ///< [rad/s]
  double acc = 0;           ///< [m/s^2]
  double range = 0;         ///< [m]
  double range_factor = 1;  ///< on ranges, whatever their unit
  TimeNs imu_offset = 0;    ///< stamp of a reading + this = time on the cameras' clock
  TimeNs range_offset = 0;  ///< stamp of a range + this = time on the IMU's clock
  /// Take an accelerometer whose first second is about 1 (or 1000) long for one in g (mg).
  bool guess_acc = false;
};

/// Without names: t, gyro xyz, acc xyz (or the accelerometer first, where its size says so).
std::unique_ptr<RowStream<ImuSample>> openImu(const std::string& path, const Units& units,
                                              ProblemLog* log);
enum class VectorKind { gyro, accelerometer };
std::unique_ptr<RowStream<VectorRow>> openVectors(const std::string& path, VectorKind kind,
                                                  const Units& units, ProblemLog* log);
/// Gyro and accelerometer in files of their own: samples at the times of the gyro.
std::unique_ptr<RowStream<ImuSample>> openSplitImu(const std::string& gyro, const std::string& acc,
                                                   const Units& units, ProblemLog* log);
/// Without names: t, filename; or t alone, for files called after their stamps.
std::unique_ptr<RowStream<ImageRow>> openImageList(const std::string& path, ProblemLog* log);
/// Without names: t, anchor_id, range; a table with a column for each anchor gives a row for each
/// range. The places of antennas are in our body, the IMU. `names` must outlive the stream.
std::unique_ptr<RowStream<RangeRow>> openRanges(const std::string& path, const Units& units,
                                                tables::AnchorNames* names, ProblemLog* log);
/// What anchors have measured to one another: by a header with `from`, `to` (or `src`, `dst`;
/// `initiator`, `responder`) and a range. Throws InputError where there is none.
std::unique_ptr<RowStream<RangeRow>> openAnchorRanges(const std::string& path, const Units& units,
                                                      tables::AnchorNames* names, ProblemLog* log);
/// What a column calls the robot's own antennas, sorted; empty: there is no such column.
std::vector<std::string> antennasIn(const std::string& path);
/// Without names: t, p xyz, q wxyz where there are commas or semicolons, q xyzw (TUM) where there
/// are none; positions only where there are no more columns.
std::unique_ptr<RowStream<PoseRow>> openGroundTruth(const std::string& path, ProblemLog* log);
/// `#id, x, y, z`. Throws InputError if the file cannot be opened.
std::vector<AnchorRow> readAnchorTable(const std::string& path, tables::AnchorNames* names,
                                       ProblemLog* log);

}  // namespace vir::euroc
