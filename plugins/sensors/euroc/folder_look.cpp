#include "folder_look.h"

#include <algorithm>
#include <filesystem>

#include "image_list.h"
#include "input_error.h"
#include "table_folder.h"
#include "video_frames.h"
#include "vir/core/parse_number.h"
#include "vir/core/text_file.h"
#include "vir/tables/layout.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

constexpr int kDepth = 4;
constexpr std::size_t kMostTables = 256;

bool deeperOrLater(const std::string& a, const std::string& b) {
  const auto depth = [](const std::string& s) { return std::count(s.begin(), s.end(), '/'); };
  return depth(a) != depth(b) ? depth(a) < depth(b) : a < b;
}

/// Files below `dir`, of a folder of many images only the first few.
void listFiles(const fs::path& dir, int depth, std::vector<std::string>* files, Found* found) {
  std::error_code ec;
  int images = 0;
  std::vector<fs::path> below;
  for (fs::directory_iterator it(dir, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) {
      if (it->path().filename().string().front() != '.') below.push_back(it->path());
    } else if (mayBeTable(it->path().string())) {
      files->push_back(it->path().string());
    } else if (const auto ending = it->path().extension(); ending == ".yaml" || ending == ".yml") {
      found->yamls.push_back(it->path().string());
    } else if (isVideoFile(it->path().string())) {
      found->videos.push_back(it->path().string());
    } else if (images < 2 && isImageFile(it->path().string()) && ++images == 2) {
      found->image_dirs.push_back(dir.string());
    }
  }
  if (depth >= kDepth) return;
  for (const fs::path& d : below) listFiles(d, depth + 1, files, found);
}

/// Three rows or more of two columns, one of which is of numbers.
bool holdsNumbers(const tables::Layout& layout) {
  if (layout.rows.size() < 3 || layout.columns < 2) return false;
  for (std::size_t c = 0; c < layout.columns; ++c) {
    const bool numbers = std::all_of(layout.rows.begin(), layout.rows.begin() + 3,
                                     [&](const std::vector<std::string>& row) {
                                       double v = 0;
                                       return c < row.size() && parseNumber(row[c], &v);
                                     });
    if (numbers) return true;
  }
  return false;
}

}  // namespace

Found lookAround(const std::string& source) {
  Found found;
  std::vector<std::string> files;
  listFiles(source, 1, &files, &found);
  std::sort(files.begin(), files.end(), deeperOrLater);
  std::sort(found.image_dirs.begin(), found.image_dirs.end(), deeperOrLater);
  std::sort(found.videos.begin(), found.videos.end(), deeperOrLater);
  std::sort(found.yamls.begin(), found.yamls.end(), deeperOrLater);
  if (files.size() > kMostTables) files.resize(kMostTables);
  for (const std::string& file : files) {
    if (!whyNoText(file).empty()) {
      found.no_text.push_back(file);
      continue;
    }
    const TableKind kind = kindOfTable(file, fs::path(file).lexically_relative(source).string());
    if (kind != TableKind::none) {
      found.tables[kind].push_back(file);
    } else if (holdsNumbers(tables::layoutOf(file))) {
      found.unused.push_back(file);
    }
  }
  return found;
}

bool isTableFolder(const std::string& source) {
  std::error_code ec;
  const fs::path root(source);
  if (fs::is_regular_file(root, ec)) return isVideoFile(source);
  if (!fs::is_directory(root, ec) || isFolder(source)) return false;
  // Folders of ours and of ROS hold tables too.
  for (const char* other : {"used.ini", "metadata.yaml"}) {
    if (fs::exists(root / other, ec)) return false;
  }
  const Found found = lookAround(fs::absolute(root).lexically_normal().string());
  if (!found.videos.empty() && !found.tables.empty()) return true;
  // It says why they cannot be read.
  const auto named = [&](const std::string& file) {
    return kindByName(fs::path(file).filename().string()) != TableKind::none;
  };
  if (found.tables.empty() && std::any_of(found.no_text.begin(), found.no_text.end(), named)) {
    return true;
  }
  return std::any_of(found.tables.begin(), found.tables.end(), [](const auto& kind) {
    return kind.first == TableKind::imu || kind.first == TableKind::gyro ||
           kind.first == TableKind::range;
  });
}

std::string listTables(const std::string& source) {
  const std::string root = folderOfSource(source);
  const Found found = lookAround(root);
  std::string out;
  const auto add = [&](const std::string& path, const std::string& what) {
    out += fs::path(path).lexically_relative(root).string() + ": " + what + "\n";
  };
  for (const auto& [kind, files] : found.tables) {
    for (const std::string& file : files) {
      const tables::Layout layout = tables::layoutOf(file);
      const int stamp = kind == TableKind::images ? tables::imageColumns(layout).stamp
                                                  : tables::stampColumn(layout);
      add(file, std::string(name(kind)) + ", " + std::to_string(layout.columns) + " columns" +
                    (kind == TableKind::anchors
                         ? std::string()
                         : std::string(", stamps in ") +
                               tables::name(tables::stampUnit(layout, stamp, 0.01).unit)));
    }
  }
  for (const std::string& dir : found.image_dirs) {
    add(dir, std::to_string(imagesIn(dir).size()) + " images");
  }
  for (const std::string& video : found.videos) {
    try {
      add(video, describeVideo(lookAtVideo(video, 0)));
    } catch (const InputError& e) {
      out += std::string(e.what()) + "\n";
    }
  }
  for (const std::string& yaml : found.yamls) add(yaml, "calibration or settings");
  for (const std::string& file : found.no_text) add(file, whyNoText(file));
  for (const std::string& file : found.unused) add(file, "a table of nothing that is imported");
  return out.empty() ? "no tables, no images\n" : out;
}

}  // namespace vir::euroc
