#pragma once
#include <string>

namespace vir::rawlog {

/// MRPT has some kinds of observations (point clouds, scans that turn, visual landmarks) in
/// libraries that nothing here is linked to, since one of them loads a hundred others. If `reason`
/// is what MRPT says of an object whose class it does not know, and one of these libraries brings
/// that class: true, and the object can be read now.
bool loadClassNamedIn(const std::string& reason);

}  // namespace vir::rawlog
