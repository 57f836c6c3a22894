#include "image_files.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "vir/core/text.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::rawlog {
namespace fs = std::filesystem;
namespace {

/// In the environment, since every plugin has this library of its own.
constexpr const char* kElsewhere = "VIR_SLAM_IMAGES_ELSEWHERE";

bool elsewhereAllowed() { return std::getenv(kElsewhere) != nullptr; }

/// Both absolute and normal.
bool isBelow(const fs::path& file, const fs::path& folder) {
  const auto ends = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return ends.first == folder.end() && ends.second != file.end();
}

bool namesAnImage(const fs::path& file) {
  const std::string extension = lowerCase(file.extension().string());
  for (const char* known : {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp", ".tif", ".tiff"}) {
    if (extension == known) return true;
  }
  return false;
}

/// For a message: a name that others chose may hold anything.
std::string shown(const std::string& name) {
  std::string text = name.substr(0, 80);
  for (char& c : text) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  return "'" + text + "'";
}

}  // namespace

void allowImagesElsewhere(bool allowed) {
  allowed ? setenv(kElsewhere, "1", 1) : unsetenv(kElsewhere);
}

ImageFile imageFileOf(const std::string& name, const std::string& rawlog,
                      const std::string& folder) {
  ImageFile out;
  const fs::path home = fs::absolute(rawlog).lexically_normal().parent_path();
  const fs::path given(name);
  const fs::path base = folder.empty() ? home : fs::path(folder);
  const fs::path file = (given.is_absolute() ? given : base / given).lexically_normal();
  if (!elsewhereAllowed() && !isBelow(file, base.lexically_normal())) {
    out.refused =
        shown(name) + " leads out of the recording's folder (--images-elsewhere allows it)";
    return out;
  }
  std::error_code error;
  const fs::file_type type = fs::symlink_status(file, error).type();
  if (type == fs::file_type::symlink) {
    const fs::path target = fs::canonical(file, error);
    if (!error && (!fs::is_regular_file(target, error) || !namesAnImage(target))) {
      out.refused = shown(name) + " is a link to something that is no image";
    }
  } else if (type != fs::file_type::regular && type != fs::file_type::not_found &&
             type != fs::file_type::none) {
    out.refused = shown(name) + " is no file";
  }
  if (out.refused.empty() && (given.is_absolute() || !folder.empty())) out.path = file.string();
  return out;
}

std::string refusedName(const std::string& folder) {
  return (fs::path(folder.empty() ? "/nowhere" : folder) / "refused" / "image").string();
}

}  // namespace vir::rawlog
