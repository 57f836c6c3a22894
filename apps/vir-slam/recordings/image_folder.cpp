#include "recordings/image_folder.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// `LABEL_<digits>.<extension>`, as the sensors name images.
bool namedByUs(const fs::path& p) {
  const std::string stem = p.stem().string();
  const std::size_t bar = stem.rfind('_');
  if (bar == std::string::npos || bar + 1 == stem.size()) return false;
  return std::all_of(stem.begin() + static_cast<std::ptrdiff_t>(bar) + 1, stem.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

void removeAll(const std::string& folder) {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
}

void rename(const std::string& from, const std::string& to) {
  std::error_code ec;
  fs::rename(from, to, ec);
  if (ec) throw std::runtime_error("cannot rename " + from + " to " + to + ": " + ec.message());
}

}  // namespace

ImageFolder::ImageFolder(std::string folder)
    : folder_(std::move(folder)), part_(folder_ + ".part"), old_(folder_ + ".old") {
  if (fs::exists(folder_)) {
    if (!fs::is_directory(folder_)) {
      throw std::runtime_error(folder_ + " is in the way: the images of the rawlog belong there");
    }
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (namedByUs(entry.path())) continue;
      throw std::runtime_error(entry.path().string() +
                               " is not an image of an import: move the folder away, or choose "
                               "another name with --out");
    }
  }
  removeAll(part_);
}

ImageFolder::~ImageFolder() {
  if (committed_) return;
  std::error_code ignored;
  if (swapped_) {
    removeAll(folder_);
    if (fs::exists(old_)) fs::rename(old_, folder_, ignored);
  }
  removeAll(part_);
}

void ImageFolder::swap() {
  removeAll(old_);
  if (fs::exists(folder_)) rename(folder_, old_);
  swapped_ = true;
  if (fs::exists(part_)) rename(part_, folder_);
}

void ImageFolder::commit() {
  removeAll(old_);
  committed_ = true;
}

}  // namespace vir::app
