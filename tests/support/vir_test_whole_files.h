#pragma once
/// Whether files are whole, as far as their kind shows it.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_temp_folder.h"

namespace vir::test {

inline bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// As many fields in each line as in the first.
inline bool wholeTable(const std::string& text, char separator) {
  if (!text.empty() && text.back() != '\n') return false;
  std::istringstream in(text);
  std::string line;
  std::ptrdiff_t fields = -1;
  while (std::getline(in, line)) {
    const std::ptrdiff_t n = std::count(line.begin(), line.end(), separator);
    if (fields >= 0 && n != fields) return false;
    fields = n;
  }
  return true;
}

inline bool wholeFile(const std::filesystem::path& file) {
  const std::string kind = file.extension().string();
  if (kind == ".rawlog") {
    rawlog::RawlogReader reader(file.string());
    while (reader.next()) continue;
    return reader.damage().empty();
  }
  const std::string text = readText(file);
  if (kind == ".json") return !nlohmann::json::parse(text, nullptr, false).is_discarded();
  if (kind == ".tum") return wholeTable(text, ' ');
  if (kind == ".csv") return wholeTable(text, ',');
  if (kind == ".svg") return endsWith(text, "</svg>\n") || endsWith(text, "</svg>");
  if (kind == ".html") return text.find("</html>") != std::string::npos;
  if (kind == ".mcap") return endsWith(text, "\x89MCAP0\r\n");
  if (kind == ".jpg") return endsWith(text, "\xff\xd9");
  if (kind == ".3Dscene") return !text.empty();
  return endsWith(text, "\n");  // ini, yaml, md, ply
}

/// Files below `folder` that have their names but are not whole. Those that say by their names that
/// they are not (`.part`, `.lock`), logs, and a folder `*.part` are left out.
inline std::string halfFiles(const std::filesystem::path& folder) {
  std::string out;
  if (!std::filesystem::exists(folder)) return out;
  for (const auto& item : std::filesystem::recursive_directory_iterator(folder)) {
    if (!item.is_regular_file()) continue;
    const std::string path = item.path().lexically_relative(folder).string();
    const std::string kind = item.path().extension().string();
    if (kind == ".part" || kind == ".lock" || kind == ".log") continue;
    if (path.find(".part/") != std::string::npos) continue;
    if (!wholeFile(item.path())) out += path + " ";
  }
  return out;
}

}  // namespace vir::test
