#include "recordings/companion.h"

#include <filesystem>
#include <fstream>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"
#include "vir/core/text_stream.h"
#include "vir/ranging/survey_table.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// `id,x,y,z`; blanks do for commas.
bool readAnchor(const std::string& line, std::int64_t* id, Vec3* p) {
  const auto words = wordsOf(line, ", \t\r");
  return words.size() == 4 && parseNumber(words[0], id) && parseFinite(words[1], &p->x()) &&
         parseFinite(words[2], &p->y()) && parseFinite(words[3], &p->z());
}

}  // namespace

std::string stemOfRawlog(const std::string& rawlog) {
  fs::path path(rawlog);
  if (path.extension() == ".gz") path.replace_extension();
  return path.replace_extension().string();
}

std::string companionOf(const std::string& rawlog) {
  const std::string path = stemOfRawlog(rawlog) + ".ini";
  std::ifstream in(path);
  std::string line;
  readLine(in, &line);
  if (line.rfind("// Written by vir-slam ", 0) != 0) return "";
  // It may hold remarks alone, e.g. which anchor has which number.
  while (readLine(in, &line)) {
    if (line.find('=') != std::string::npos && line.rfind("//", 0) != 0) return path;
  }
  return "";
}

std::string anchorNamesOf(const std::string& rawlog) {
  std::ifstream in(stemOfRawlog(rawlog) + ".ini");
  std::string out;
  for (std::string line; readLine(in, &line);) {
    const auto words = wordsOf(line);
    if (words.size() != 5 || words[0] != "//" || words[1] != "anchor" || words[3] != "is") continue;
    std::uint64_t number = 0;
    const std::string_view name = words[4];
    if (!parseNumber(words[2], &number) || name.size() < 3 || name.front() != '\'') continue;
    if (!out.empty()) out += ' ';
    out += std::string(name.substr(1, name.size() - 2)) + "=" + std::to_string(number);
  }
  return out;
}

AnchorTable anchorsTruthOf(const std::string& rawlog) {
  AnchorTable table;
  const std::string path = stemOfRawlog(rawlog) + "_anchors_truth.csv";
  TextStream in(path);
  if (!in) return table;
  table.path = path;
  for (std::string line; readLine(in, &line);) {
    if (line.empty() || line[0] == '#' || line[0] == '\r') continue;
    std::int64_t id = 0;
    Vec3 p;
    const bool good = readAnchor(line, &id, &p) &&
                      table.anchors.emplace(static_cast<std::uint64_t>(id), p).second;
    if (!good) ++table.bad_lines;
  }
  return table;
}

std::vector<SurveyedAnchor> surveyOf(const std::string& rawlog) {
  const std::string path = stemOfRawlog(rawlog) + "_anchors.csv";
  if (!fs::is_regular_file(path)) return {};
  try {
    return ranging::surveyFromText(readTextFile(path, std::size_t{16} << 20), path,
                                   ranging::anchorNumbers(anchorNamesOf(rawlog)));
  } catch (const std::runtime_error&) {
    return {};
  }
}

}  // namespace vir::app
