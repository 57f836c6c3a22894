#pragma once
/// A recording as one stream in time order, whatever files it comes from.
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "euroc_options.h"
#include "folder.h"
#include "image_survey.h"
#include "problem_log.h"
#include "range_simulator.h"
#include "readers.h"
#include "sensor_yaml.h"

namespace vir::euroc {

/// One thing that happened. Poses are those of our body frame, which is the IMU's.
struct Event {
  TimeNs t = 0;
  std::variant<ImuRow, RangeRow, PoseRow, ImageRow> what;
  std::string where;  ///< file and line, of images only
};

/// Opens the folder and merges its files. Memory does not depend on their length.
class Recording {
 public:
  /// Throws InputError if this is no recording or a calibration is missing or wrong. `log` must
  /// outlive the recording.
  Recording(const EurocOptions& options, ProblemLog* log);

  /// The next event in time; at one stamp IMU, range, ground truth, image. False at the end.
  bool next(Event* event);
  double progress() const;

  const Folder& folder() const { return folder_; }
  /// Empty without a camera. `T_B_C` is from our body (the IMU) here.
  const std::optional<CameraYaml>& camera() const { return camera_; }
  /// How pixels of 16 bits become 8.
  const Stretch& stretch() const { return stretch_; }
  const ImuYaml& imu() const { return imu_calibration_; }
  /// Stamp of an image + this = its time on the IMU's clock [s]; empty: not known.
  std::optional<double> timeOffset() const { return time_offset_s_; }
  Vec3 antennaInBody() const { return antenna_; }  ///< [m]
  double rangeSigma() const { return range_sigma_m_; }
  /// Where the anchors of the ranges truly are: drawn ones by the settings, others by
  /// mav0/uwb0/anchors_truth.csv. Empty: not known.
  const std::vector<AnchorRow>& trueAnchors() const { return true_anchors_; }

 private:
  void openCalibration(const EurocOptions& o);
  void openCamera(const EurocOptions& o);
  void openStreams(const EurocOptions& o);
  void findTrueAnchors(const EurocOptions& o);
  void skipOtherAntennas();
  void noteAnchorNames();
  /// Some images, spread over all of the list, as full names.
  std::vector<std::string> someImages() const;
  void fitToImages();
  void watchGap(TimeNs t, TimeNs* last, const char* counter, const std::string& file);

  ProblemLog* log_;
  /// For the second reading of the ground truth: its faults are reported once.
  ProblemLog silent_;
  Folder folder_;
  std::optional<CameraYaml> camera_;
  ImuYaml imu_calibration_;
  std::optional<double> time_offset_s_;
  Stretch stretch_;
  tables::AnchorNames anchor_names_;
  std::string wanted_antenna_;
  bool said_truth_lever_ = false;
  Vec3 antenna_ = Vec3::Zero();
  double range_sigma_m_ = 0;
  std::vector<AnchorRow> true_anchors_;
  Pose T_S_B_truth_;  ///< our body in the frame whose pose the ground truth gives

  std::unique_ptr<RowCursor<ImuRow>> imu_;
  std::unique_ptr<RowCursor<ImageRow>> images_;
  std::unique_ptr<RowCursor<RangeRow>> ranges_;
  std::unique_ptr<RowCursor<PoseRow>> truth_;
  std::unique_ptr<RangeSimulator> drawn_;

  TimeNs from_ = 0, until_ = 0;
  TimeNs now_ = 0, last_imu_ = 0, last_image_ = 0;
};

}  // namespace vir::euroc
