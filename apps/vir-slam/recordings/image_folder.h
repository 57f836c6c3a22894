#pragma once
#include <string>

namespace vir::app {

/// The folder of external images beside a rawlog, replaced as a whole when the rawlog is: new
/// images go to `<folder>.part`, which takes the folder's name at commit().
class ImageFolder {
 public:
  /// Throws std::runtime_error if `folder` is there and holds anything but images we named: it is
  /// not ours to replace.
  explicit ImageFolder(std::string folder);
  /// Without commit(), what was written is removed and an old folder stays as it was.
  ~ImageFolder();
  ImageFolder(const ImageFolder&) = delete;
  ImageFolder& operator=(const ImageFolder&) = delete;

  const std::string& workingFolder() const { return part_; }
  /// Puts the new folder (if any image was written) in the place of the old one. Throws
  /// std::runtime_error; the old one is back then.
  void swap();
  /// The new rawlog is complete too: the old images go.
  void commit();

 private:
  std::string folder_, part_, old_;
  bool swapped_ = false, committed_ = false;
};

}  // namespace vir::app
