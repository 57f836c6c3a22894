#pragma once
/// Where the parts of a recording lie.
#include <string>

namespace vir::euroc {

struct Folder {
  std::string mav0;
  std::string camera_dir;  ///< empty: no camera wanted
  std::string imu_dir;
  std::string uwb_dir;            ///< empty: none
  std::string ground_truth_file;  ///< empty: none
  std::string ground_truth_dir;
};

/// Does `source` contain mav0, or is it mav0?
bool isFolder(const std::string& source);

/// `source` contains mav0 or is it. Throws InputError that says what is missing and what is there.
Folder findFolder(const std::string& source, const std::string& camera);

}  // namespace vir::euroc
