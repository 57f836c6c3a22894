#pragma once
/// A look at some images of a recording before the first is imported.
#include <string>
#include <vector>

namespace vir::euroc {

struct ImageSurvey {
  int width = 0, height = 0;  ///< of the first that can be decoded; 0: none can
  bool sixteen_bit = false;
  /// Between these lies all but a thousandth on either side; 0 of images that are bright enough.
  double low = 0, high = 0;
};

ImageSurvey surveyImages(const std::vector<std::string>& files);

/// What pixels become 0 and 255 (`black`, `white`). Of 16 bits: the whole of the bits that are in
/// use where that leaves enough contrast, else what the recording holds, with room on both sides.
/// Of 8 bits they stay as they are, unless the whole recording uses few of its values.
struct Stretch {
  double black = 0, white = 65535;
  bool eight_bit = false;  ///< of 8 bits, which do not stay as they are
  std::string said;        ///< for the report; empty: the plain division by 257
};
Stretch stretchOf(const ImageSurvey& survey);

/// Where the file of a row is: as listed below `camera_dir`/data or `camera_dir`, by its last part,
/// or with an extension added. As below data where there is none of them.
std::string imageFile(const std::string& camera_dir, const std::string& listed);

}  // namespace vir::euroc
