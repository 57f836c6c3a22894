#include "vir/geometry/axes.h"

#include <Eigen/LU>
#include <sstream>
#include <stdexcept>

namespace vir {
inline namespace geometry {

Mat3 axesRotation(const std::string& text) {
  const std::invalid_argument bad("`" + text +
                                  "` is no rotation; write three axes, e.g. x y z or x -y -z");
  std::istringstream words(text);
  Mat3 R = Mat3::Zero();
  std::string word;
  for (int row = 0; row < 3; ++row) {
    if (!(words >> word)) throw bad;
    const bool minus = word.front() == '-';
    if (minus || word.front() == '+') word.erase(0, 1);
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') throw bad;
    R(row, word[0] - 'x') = minus ? -1 : 1;
  }
  if (R.determinant() != 1 || (words >> word)) throw bad;
  return R;
}

}  // namespace geometry
}  // namespace vir
