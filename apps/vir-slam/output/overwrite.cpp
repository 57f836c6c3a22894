#include "output/overwrite.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

std::string beginOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(64, '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return begin;
}

bool beginsWith(const std::string& text, const std::string& with) {
  return text.compare(0, with.size(), with) == 0;
}

/// Compressed, or the name of a first object's class behind its length.
bool isRawlog(const std::string& begin) {
  if (beginsWith(begin, "\x1f\x8b")) return true;
  return begin.size() > 2 && (static_cast<unsigned char>(begin[0]) & 0x80) != 0 &&
         (beginsWith(begin.substr(1), "mrpt::") || begin[1] == 'C');
}

bool isPicture(const fs::path& file, const std::string& begin) {
  return file.extension() == ".png" ? beginsWith(begin, "\x89PNG") : begin[0] == '<';
}

/// By its first bytes.
bool isOfItsKind(const fs::path& file, Written what) {
  const std::string begin = beginOf(file);
  if (begin.empty()) return true;
  switch (what) {
    case Written::rawlog:
      return isRawlog(begin);
    case Written::json:
      return begin[0] == '{' || begin[0] == '[';
    case Written::picture:
      return isPicture(file, begin);
    case Written::calibration:
      return beginsWith(begin, "# Camera and IMU as estimated");
    case Written::range_bias:
      return beginsWith(begin, "# vir-slam range bias model");
    case Written::mcap:
      return beginsWith(begin, "\x89MCAP0\r\n");
    case Written::map:
      return beginsWith(begin, "VIR-MAP\n");
    case Written::film:
      return false;  // nothing in it says whose it is
    case Written::results:
      break;
  }
  return true;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw UsageError(path + " " + why +
                   " and is not overwritten: give another name, or --force to write over it");
}

}  // namespace

void refuseToOverwrite(const std::string& path, Written what, const Common& common) {
  if (path == "-") throw UsageError("'-' is no file here: give a name (./- for one called so)");
  std::error_code ignored;
  if (common.force || path.empty() || !fs::exists(path, ignored)) return;
  if (what == Written::results) {
    const std::string foreign = results::foreignFileIn(path);
    if (!foreign.empty()) refuse(foreign, "is there already, without a run that it belongs to,");
  } else if (fs::is_regular_file(path, ignored) && !isOfItsKind(path, what)) {
    refuse(path, "exists already, is not what this command writes");
  }
}

}  // namespace vir::app
