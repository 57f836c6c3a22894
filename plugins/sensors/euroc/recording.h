#pragma once
/// A recording as one stream in time order, whatever files it comes from.
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "anchor_places.h"
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
  std::size_t stream = 0;  ///< which of the cameras(), which of the rangeStreams()
  std::variant<ImuSample, RangeRow, PoseRow, ImageRow> what;
  std::string where;  ///< file and line, of images only
};

struct CameraStream {
  CameraFiles files;
  std::string label;
  CameraYaml calibration;  ///< `T_B_C` is from our body (the IMU) here
  /// Stamp of an image + this = its time on the IMU's clock [s]; empty: not known.
  std::optional<double> time_offset_s;
  Stretch stretch;                      ///< how pixels of 16 bits become 8
  int file_width = 0, file_height = 0;  ///< of the images before they are resized
  std::unique_ptr<RowStream<ImageRow>> rows;
};

struct RangeStream {
  std::string label;            ///< empty: ranges between anchors
  Vec3 antenna = Vec3::Zero();  ///< in our body [m], where a row does not say its place
  bool by_settings = false;     ///< `antenna` holds, whatever a row says
  double sigma_m = 0;           ///< where a row does not say it
  std::string only;             ///< the antenna whose ranges these are; empty: all
  std::set<std::string> known;  ///< antennas of the same table with a label of their own
  bool tells = true;            ///< counts what no label takes
  std::unique_ptr<RowStream<RangeRow>> rows;
};

/// Opens the files and merges them. Memory does not depend on their length.
class Recording {
 public:
  /// A folder in EuRoC's layout. Throws InputError if this is no recording or a calibration is
  /// missing or wrong. `log` must outlive the recording.
  Recording(const EurocOptions& options, ProblemLog* log);
  /// Any files.
  Recording(Folder folder, const EurocOptions& options, ProblemLog* log);

  /// The next event in time; at one stamp IMU, range, ground truth, image. False at the end.
  bool next(Event* event);
  double progress() const;

  const Folder& folder() const { return folder_; }
  const std::vector<CameraStream>& cameras() const { return cameras_; }
  const std::vector<RangeStream>& rangeStreams() const { return ranges_; }
  const tables::AnchorNames& anchorNames() const { return anchor_names_; }
  const ImuYaml& imu() const { return imu_calibration_; }
  /// Of the cameras beside the first, see formats::otherTimeOffsets().
  std::vector<double> otherTimeOffsets() const;
  /// Of drawn ranges, and of files that do not say.
  Vec3 antennaInBody() const { return antenna_; }  ///< [m]
  /// Where the anchors of the ranges truly are: drawn ones by the settings, others by
  /// anchors_truth.csv beside the ranges. Empty: not known.
  const std::vector<AnchorRow>& trueAnchors() const { return true_anchors_; }
  /// Where the rows read so far say that the anchors are.
  const AnchorPlaces& anchorPlaces() const { return anchor_places_; }

 private:
  /// What goes before the cameras' own; empty: nothing.
  std::string calibrationFile(const EurocOptions& o) const;
  void openCalibration(const EurocOptions& o);
  void openCamera(const EurocOptions& o, CameraStream* camera, bool first);
  void openStreams(const EurocOptions& o);
  void openRangeStreams(const EurocOptions& o);
  void setWindow(const EurocOptions& o, TimeNs origin);
  void findTrueAnchors(const EurocOptions& o);
  void skipTo(TimeNs t);
  void noteAnchorNames();
  TimeNs nextTime() const;
  void takePose(Event* event);
  bool takeRange(Event* event);
  void takeImage(Event* event);
  void watchGap(TimeNs t, TimeNs* last, const char* counter, const std::string& file);

  ProblemLog* log_;
  /// For the second reading of the ground truth: its faults are reported once.
  ProblemLog silent_;
  Folder folder_;
  std::string section_;
  Units units_;
  ImuYaml imu_calibration_;
  tables::AnchorNames anchor_names_;
  AnchorPlaces anchor_places_;
  bool said_truth_lever_ = false;
  Vec3 antenna_ = Vec3::Zero();
  std::vector<AnchorRow> true_anchors_;
  Pose T_S_B_truth_;  ///< our body in the frame whose pose the ground truth gives

  std::unique_ptr<RowStream<ImuSample>> imu_;
  std::vector<CameraStream> cameras_;
  std::vector<RangeStream> ranges_;
  std::unique_ptr<RowStream<PoseRow>> truth_;
  std::unique_ptr<RangeSimulator> drawn_;

  TimeNs from_ = 0, until_ = 0;
  TimeNs now_ = 0, last_imu_ = 0, last_image_ = 0;
};

}  // namespace vir::euroc
