#pragma once
#include <string>

namespace vir::rawlog {

/// Where the image of a recording is.
struct ImageFile {
  std::string path;     ///< absolute where the folder is known
  std::string refused;  ///< empty, or why it may not be read
};

/// `name` as it stands in the rawlog `rawlog`, whose images are in `folder` (may be empty). A
/// rawlog is a file that others wrote: a name in it must not lead to other files of the user's. A
/// link in the folder may lead anywhere, since `import` makes such links, but only to an image.
ImageFile imageFileOf(const std::string& name, const std::string& rawlog,
                      const std::string& folder);

/// A name that no file has, for an image that was refused.
std::string refusedName(const std::string& folder);

}  // namespace vir::rawlog
