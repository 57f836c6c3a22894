#pragma once
/// Where this checkout and its build are. Told at link time by one small file: paths in the tests
/// themselves would keep a compiler cache from using the objects of another checkout.
#include <string>

namespace vir::test {

/// The checkout; no slash at the end.
std::string sourceDir();
/// The build folder; no slash at the end.
std::string buildDir();

}  // namespace vir::test
