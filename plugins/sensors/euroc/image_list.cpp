#include "image_list.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <ctime>
#include <filesystem>
#include <regex>
#include <set>

#include "image_survey.h"
#include "input_error.h"
#include "vir/core/text.h"
#include "vir/core/time_bounds.h"
#include "vir/tables/layout.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

constexpr double kImageStep = 0.05;  // [s], to tell the unit of stamps that are no dates
constexpr std::size_t kMostImages = 5'000'000;

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Date and time of day (`IMG_20140624_190304763`), taken for UTC, as seconds.
std::string dateIn(const std::string& stem) {
  static const std::regex pattern(
      R"((?:^|\D)((?:19|20)\d\d)[-_.]?(\d\d)[-_.]?(\d\d)[-_ T](\d\d)[-_.:h]?(\d\d)[-_.:m]?(\d\d)[-_.,]?(\d{0,9})(?!\d))");
  std::smatch m;
  if (!std::regex_search(stem, m, pattern)) return {};
  const auto part = [&m](std::size_t i) { return std::stoi(m[i].str()); };
  std::tm t{};
  t.tm_year = part(1) - 1900;
  t.tm_mon = part(2) - 1;
  t.tm_mday = part(3);
  t.tm_hour = part(4);
  t.tm_min = part(5);
  t.tm_sec = part(6);
  const bool possible = t.tm_mon >= 0 && t.tm_mon < 12 && t.tm_mday > 0 && t.tm_mday < 32 &&
                        t.tm_hour < 24 && t.tm_min < 60 && t.tm_sec < 61 && part(1) >= 1970;
  if (!possible) return {};
  const std::string fraction = m[7].str();
  return std::to_string(timegm(&t)) + "." + (fraction.empty() ? "0" : fraction);
}

/// Seconds and nanoseconds with something between that is no point (`1403636584_763555584`).
std::string secondsIn(const std::string& stem) {
  static const std::regex pattern(R"((?:^|\D)([12]\d{9})[-_,](\d{9})(?!\d))");
  std::smatch m;
  return std::regex_search(stem, m, pattern) ? m[1].str() + "." + m[2].str() : std::string();
}

/// The longest number in a name without its ending: `frame_000012_1403636579.763` has the second.
std::string numberIn(const std::string& stem) {
  std::string best;
  for (std::size_t i = 0; i < stem.size();) {
    if (!isDigit(stem[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    bool point = false;
    while (end < stem.size() &&
           (isDigit(stem[end]) ||
            (!point && stem[end] == '.' && end + 1 < stem.size() && isDigit(stem[end + 1])))) {
      point = point || stem[end] == '.';
      ++end;
    }
    if (end - i > best.size()) best = stem.substr(i, end - i);
    i = end;
  }
  return best;
}

/// Names with numbers of different lengths in the order of the numbers.
bool before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!isDigit(a[i]) || !isDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    const auto run = [](const std::string& s, std::size_t* at) {
      while (*at < s.size() && s[*at] == '0') ++*at;
      const std::size_t from = *at;
      while (*at < s.size() && isDigit(s[*at])) ++*at;
      return s.substr(from, *at - from);
    };
    const std::string x = run(a, &i), y = run(b, &j);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  return a.size() - i < b.size() - j || (a.size() - i == b.size() - j && a < b);
}

std::unique_ptr<RowStream<ImageRow>> byNames(const CameraFiles& camera, ProblemLog* log) {
  const std::vector<std::string> files = imagesIn(camera.dir);
  std::vector<std::string> numbers, sample;
  std::size_t digits = 0;
  for (const std::string& file : files) {
    const std::string stem = fs::path(file).stem().string();
    std::string number = dateIn(stem);
    if (number.empty()) number = secondsIn(stem);
    numbers.push_back(number.empty() ? numberIn(stem) : number);
    digits = std::max(digits, numbers.back().size());
    if (sample.size() < tables::Layout::kSampled) sample.push_back(numbers.back());
  }
  const tables::UnitGuess guess = tables::guessUnit(sample, kImageStep);
  // 000001.png counts; a clock's numbers are longer.
  if (files.empty() || !guess.sure || digits < 9) {
    throw InputError(camera.dir + ": " +
                     (files.empty() ? "holds no images"
                                    : "the names of the images (" +
                                          fs::path(files.front()).filename().string() +
                                          ", ...) hold no time") +
                     "; give a list of stamps and files: --topic camera=LIST.csv");
  }
  std::vector<ImageRow> rows;
  for (std::size_t i = 0; i < files.size(); ++i) {
    ImageRow row;
    row.file = files[i];
    if (tables::parseStamp(numbers[i], guess.unit, &row.t) && isStamp(row.t)) {
      rows.push_back(row);
    } else {
      log->add("image_without_stamp", files[i], "its name holds no time");
    }
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const ImageRow& a, const ImageRow& b) { return a.t < b.t; });
  log->note(camera.dir + ": the times of the images are those in their names, in " +
            tables::name(guess.unit));
  return std::make_unique<ListedRows<ImageRow>>(camera.dir, "image", std::move(rows));
}

bool isFile(const std::string& path) {
  std::error_code ec;
  return fs::is_regular_file(path, ec);
}

/// Rows whose files do not exist take the images of the folder in order, if there are as many.
std::unique_ptr<RowStream<ImageRow>> inOrder(const CameraFiles& camera, ProblemLog* log) {
  const std::vector<std::string> files = imagesIn(camera.dir);
  ProblemLog of_list;
  const auto list = openImageList(camera.list, &of_list);
  std::vector<ImageRow> rows;
  for (; list->peek() != nullptr && rows.size() < kMostImages; list->pop()) {
    rows.push_back(*list->peek());
  }
  if (files.empty() || files.size() != rows.size()) return nullptr;
  log->takeOver(of_list);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].file = files[i];
  log->note(camera.list + ": holds stamps only, " + std::to_string(rows.size()) +
            ", as many as there are images: they were given out in the order of the names");
  return std::make_unique<ListedRows<ImageRow>>(camera.list, "image", std::move(rows));
}

}  // namespace

bool isImageFile(const std::string& path) {
  const std::string e = lowerCase(fs::path(path).extension().string());
  static const std::set<std::string> known{".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                           ".bmp", ".pgm", ".ppm",  ".webp"};
  return known.count(e) > 0;
}

std::vector<std::string> imagesIn(const std::string& dir) {
  std::vector<std::string> files;
  for (const fs::path& place : {fs::path(dir), fs::path(dir) / "data"}) {
    std::error_code ec;
    for (fs::directory_iterator it(place, ec), end; !ec && it != end; it.increment(ec)) {
      if (isImageFile(it->path().string()) && files.size() < kMostImages) {
        files.push_back(it->path().string());
      }
    }
    if (!files.empty()) break;
  }
  std::sort(files.begin(), files.end(), before);
  return files;
}

std::unique_ptr<RowStream<ImageRow>> openImages(const CameraFiles& camera, ProblemLog* log) {
  if (camera.list.empty()) return byNames(camera, log);
  const tables::Layout layout = tables::layoutOf(camera.list);
  if (layout.columns == 1 || tables::imageColumns(layout).file < 0) {
    ProblemLog silent;
    const auto list = openImageList(camera.list, &silent);
    const bool found = list->peek() != nullptr && isFile(imageFile(camera.dir, list->peek()->file));
    if (!found) {
      if (auto rows = inOrder(camera, log)) return rows;
    }
  }
  return openImageList(camera.list, log);
}

}  // namespace vir::euroc
