#pragma once
/// A look at some images of a recording before the first is imported.
#include <string>
#include <vector>

namespace vir::euroc {

struct ImageSurvey {
  int width = 0, height = 0;  ///< of the first that can be decoded; 0: none can
  bool sixteen_bit = false;
  double low = 0, high = 0;  ///< between these lies all but a thousandth on either side
};

ImageSurvey surveyImages(const std::vector<std::string>& files);

/// What 16-bit pixels become 0 and 255 (`black`, `white`): the whole of the bits that are in use
/// where that leaves enough contrast, else what the recording holds, with room on both sides.
struct Stretch {
  double black = 0, white = 65535;
  std::string said;  ///< for the report; empty: the plain division by 257
};
Stretch stretchOf(const ImageSurvey& survey);

/// Where the file of a row is: as listed below `camera_dir`/data or `camera_dir`, by its last part,
/// or with an extension added. As below data where there is none of them.
std::string imageFile(const std::string& camera_dir, const std::string& listed);

}  // namespace vir::euroc
