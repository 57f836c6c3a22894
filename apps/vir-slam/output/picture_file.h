#pragma once
/// A figure in the format that the file's name asks for.
#include <string>

#include "vir/evaluation/figure.h"

namespace vir::app {

/// Throws UsageError that names `option` unless `path` ends in .svg or .png.
void requirePicture(const std::string& option, const std::string& path);

/// Throws std::runtime_error if it cannot be written.
void writePicture(const evaluation::Figure& figure, const std::string& path);

}  // namespace vir::app
