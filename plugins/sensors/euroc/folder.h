#pragma once
/// Which files of a recording hold what.
#include <string>
#include <vector>

namespace vir::euroc {

struct CameraFiles {
  std::string name;   ///< "cam0", ...; its images are CAM0
  std::string dir;    ///< images are here or in `data` below
  std::string list;   ///< empty: the images are called after their stamps
  std::string video;  ///< a file that holds the images; `list` has its frames' times, or is empty
  std::string yaml;   ///< sensor.yaml; empty: none
};

struct RangeFiles {
  std::string name;  ///< "uwb0", ...; its ranges are UWB0
  std::string file;
  std::string yaml;              ///< where the antenna is; empty: none
  std::string anchors;           ///< where the anchors truly are; empty: none
  bool between_anchors = false;  ///< what anchors have measured to one another; no label of its own
};

struct Folder {
  std::string root;                  ///< mav0, or the folder of tables
  std::vector<CameraFiles> cameras;  ///< the estimator's first; empty: none wanted
  std::string imu_file;
  std::string accelerometer_file;  ///< empty: it is in `imu_file`, else that is the gyro's
  std::string imu_yaml;            ///< empty: none
  std::vector<RangeFiles> ranges;
  std::string truth_file;           ///< empty: none
  std::string truth_yaml;           ///< empty: none
  std::string calibration;          ///< found beside tables or cameras; empty: none
  std::vector<std::string> unread;  ///< tables that are called after what is not there otherwise
  std::vector<std::string> without_images;  ///< lists of images that are not there
  std::vector<std::string> notes;
};

/// "CAM1" of "cam1", where `first` is the label of the first of its kind; that of a name without a
/// number.
std::string labelOf(const std::string& name, const char* first);

/// Does `source` contain mav0, or is it mav0?
bool isFolder(const std::string& source);

/// `source` contains mav0 or is it. `camera` is the estimator's, or "none"; others that are there
/// follow. Throws InputError that says what is missing and what is there.
Folder findFolder(const std::string& source, const std::string& camera);

}  // namespace vir::euroc
