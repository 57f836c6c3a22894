#include "recordings/companion.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"
#include "vir/core/text_stream.h"
#include "vir/ranging/survey_table.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// `id,x,y,z`; blanks do for commas.
bool readAnchor(const std::string& line, std::uint64_t* id, Vec3* p) {
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

AnchorTexts anchorTextsIn(const std::string& ini) {
  std::istringstream in(ini);
  AnchorTexts out;
  for (std::string line; readLine(in, &line);) {
    const auto words = wordsOf(line);
    if (words.size() < 5 || words[0] != "//" || words[1] != "anchor" || words[3] != "is") continue;
    std::uint64_t number = 0;
    const std::size_t first = line.find('\''), last = line.rfind('\'');
    if (!parseNumber(words[2], &number) || first == line.npos || last < first + 2) continue;
    out[number] = line.substr(first + 1, last - first - 1);
  }
  return out;
}

AnchorTexts anchorTextsOf(const std::string& rawlog) {
  const std::string path = stemOfRawlog(rawlog) + ".ini";
  if (!fs::is_regular_file(path)) return {};
  try {
    return anchorTextsIn(readTextFile(path, std::size_t{1} << 20));
  } catch (const std::runtime_error&) {
    return {};
  }
}

std::string anchorText(const AnchorTexts& texts, std::uint64_t id) {
  const auto named = texts.find(id);
  return named == texts.end() ? std::to_string(id) : named->second;
}

void callAnchors(const AnchorTexts& texts, std::string* text) {
  if (texts.empty()) return;
  constexpr const char* kDigits = "0123456789";
  for (std::size_t at = 0; (at = text->find_first_of(kDigits, at)) != std::string::npos;) {
    const std::size_t end = std::min(text->find_first_not_of(kDigits, at), text->size());
    std::uint64_t number = 0;
    const auto named = parseNumber(std::string_view(*text).substr(at, end - at), &number)
                           ? texts.find(number)
                           : texts.end();
    if (named == texts.end()) {
      at = end;
      continue;
    }
    text->replace(at, end - at, named->second);
    at += named->second.size();
  }
}

std::string anchorNamesOf(const std::string& rawlog) {
  ranging::AnchorNumbers numbers;
  for (const auto& [number, name] : anchorTextsOf(rawlog)) numbers[name] = number;
  return ranging::anchorNumbersText(numbers);
}

AnchorTable anchorsTruthOf(const std::string& rawlog) {
  AnchorTable table;
  const std::string path = stemOfRawlog(rawlog) + "_anchors_truth.csv";
  TextStream in(path);
  if (!in) return table;
  table.path = path;
  for (std::string line; readLine(in, &line);) {
    if (line.empty() || line[0] == '#' || line[0] == '\r') continue;
    std::uint64_t id = 0;
    Vec3 p;
    const bool good = readAnchor(line, &id, &p) && table.anchors.emplace(id, p).second;
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
