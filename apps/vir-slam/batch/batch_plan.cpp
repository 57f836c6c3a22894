#include "batch/batch_plan.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// Names become folders and cells of a table.
void checkName(const Setting& setting, const std::string& name) {
  const bool good = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_';
  });
  if (!good) throw SettingsError(setting, "'" + name + "' is no name: letters, digits and _ only");
}

std::vector<std::string> namesIn(const Setting& setting) {
  const auto words = wordsOf(setting.value);
  const std::vector<std::string> names(words.begin(), words.end());
  std::set<std::string> seen;
  for (const std::string& name : names) {
    checkName(setting, name);
    if (!seen.insert(name).second) throw SettingsError(setting, "'" + name + "' is there twice");
  }
  return names;
}

std::vector<int> seedsIn(const Setting& setting) {
  std::vector<int> seeds;
  for (const std::string_view word : wordsOf(setting.value)) {
    int seed = 0;
    if (!parseNumber(word, &seed) || seed < 0 || seed > 1000000) {
      throw SettingsError(setting, "seeds are whole numbers from 0 to 1000000 with blanks between");
    }
    if (std::count(seeds.begin(), seeds.end(), seed) > 0) {
      throw SettingsError(setting, "seed " + std::string(word) + " is there twice");
    }
    seeds.push_back(seed);
  }
  if (seeds.empty()) throw SettingsError(setting, "no seed named");
  return seeds;
}

/// Reads a section of the plan: known keys, and those with a dot which go to the program called.
class SectionReader {
 public:
  SectionReader(const Settings& settings, std::string section)
      : settings_(settings), section_(std::move(section)) {}

  const Setting* find(const char* key) {
    known_.insert(key);
    return settings_.find(section_, key);
  }
  std::string text(const char* key) {
    const Setting* setting = find(key);
    return setting != nullptr ? setting->value : std::string();
  }
  /// A path relative to the ini; must exist.
  std::string file(const char* key) {
    const Setting* setting = find(key);
    if (setting == nullptr || setting->value.empty()) return "";
    fs::path path(setting->value);
    if (path.is_relative() && setting->origin.line > 0) {
      path = fs::path(settings_.name()).parent_path() / path;
    }
    if (!fs::is_regular_file(path))
      throw SettingsError(*setting, "there is no file " + path.string());
    return path.lexically_normal().string();
  }
  /// Throws SettingsError for keys nobody asked for that have no dot.
  Assignments rest() const {
    Assignments out;
    for (const Setting& s : settings_.all()) {
      if (lowerCase(s.section) != lowerCase(section_) || known_.count(lowerCase(s.key)) > 0)
        continue;
      if (s.key.find('.') == std::string::npos) {
        std::string allowed;
        for (const std::string& key : known_) allowed += " " + key;
        throw SettingsError(
            s, "unknown here; allowed:" + allowed + ", and Section.key of the program called");
      }
      out.emplace_back(s.key, s.value);
    }
    return out;
  }

 private:
  const Settings& settings_;
  std::string section_;
  std::set<std::string> known_;
};

constexpr const char* kExample = R"(

A benchmark that works, beside the ini it names (ini/benchmark.ini is a larger one):
  [Batch]
  sequences = flight
  settings = with_ranges without
  ini = euroc.ini

  [Sequence_flight]
  rawlog = flight.rawlog

  [Setting_with_ranges]

  [Setting_without]
  Estimator.use_ranges = false)";

SettingsError missing(const Settings& settings, const std::string& section,
                      const std::string& problem) {
  return {{settings.name(), 0}, section, "", problem + kExample};
}

BatchSequence readSequence(const Settings& settings, const std::string& name,
                           const std::vector<std::string>& conditions,
                           const std::vector<int>& seeds) {
  const std::string section = "Sequence_" + name;
  if (!settings.hasSection(section)) throw missing(settings, section, "there is no such section");
  SectionReader in(settings, section);
  BatchSequence s;
  s.name = name;
  s.rawlog = in.file("rawlog");
  s.world = in.file("world");
  s.note = in.text("note");
  if (s.rawlog.empty() == s.world.empty()) {
    throw missing(settings, section, "needs either rawlog = FILE or world = INI");
  }
  const Setting* own_conditions = in.find("conditions");
  const Setting* own_seeds = in.find("seeds");
  s.set = in.rest();
  if (!s.rawlog.empty()) {
    if (own_conditions != nullptr || own_seeds != nullptr || !s.set.empty()) {
      throw missing(settings, section, "a rawlog has no conditions, seeds or settings of a world");
    }
    return s;
  }
  s.conditions = own_conditions != nullptr ? namesIn(*own_conditions) : conditions;
  s.seeds = own_seeds != nullptr ? seedsIn(*own_seeds) : seeds;
  return s;
}

BatchCondition readCondition(const Settings& settings, const std::string& name) {
  const std::string section = "Condition_" + name;
  BatchCondition c;
  c.name = name;
  // `plain` needs no section: the world as it is.
  if (settings.hasSection(section)) c.set = SectionReader(settings, section).rest();
  if (c.set.empty() && name != "plain" && !settings.hasSection(section)) {
    throw missing(settings, section, "there is no such section");
  }
  return c;
}

BatchSetting readSetting(const Settings& settings, const std::string& name,
                         const std::string& ini) {
  const std::string section = "Setting_" + name;
  if (!settings.hasSection(section)) throw missing(settings, section, "there is no such section");
  SectionReader in(settings, section);
  BatchSetting s;
  s.name = name;
  s.title = in.text("title");
  s.ini = in.file("ini");
  if (s.ini.empty()) s.ini = ini;
  if (s.ini.empty()) throw missing(settings, section, "no ini, neither here nor in [Batch]");
  s.set = in.rest();
  return s;
}

/// Sections may be left out of the lists in [Batch], but not be of another kind.
void checkSections(const Settings& settings) {
  for (const std::string& section : settings.sections()) {
    const std::string name = lowerCase(section);
    if (name == "batch" || name.rfind("sequence_", 0) == 0 || name.rfind("condition_", 0) == 0 ||
        name.rfind("setting_", 0) == 0) {
      continue;
    }
    throw missing(settings, section,
                  "unknown section; allowed: [Batch], [Sequence_NAME], [Condition_NAME], "
                  "[Setting_NAME]");
  }
}

}  // namespace

BatchPlan readBatchPlan(const std::string& file, const std::vector<std::string>& extra) {
  Settings settings = Settings::fromFile(file);
  for (const std::string& assignment : extra) settings.set(assignment);
  checkSections(settings);
  SectionReader in(settings, "Batch");
  BatchPlan plan;
  plan.file = file;
  const Setting* sequences = in.find("sequences");
  const Setting* names = in.find("settings");
  if (sequences == nullptr || names == nullptr) {
    throw missing(settings, "Batch", "needs sequences = NAMES and settings = NAMES");
  }
  const Setting* conditions = in.find("conditions");
  const Setting* seeds = in.find("seeds");
  const std::string ini = in.file("ini");
  std::string timeout = in.text("timeout_s"), keep = in.text("keep_recordings");
  if (!timeout.empty()) {
    if (!parseNumber(timeout, &plan.timeout_s) || !(plan.timeout_s > 0)) {
      throw SettingsError(*in.find("timeout_s"), "seconds above 0 are asked for");
    }
  }
  if (!keep.empty() && !parseBool(keep, &plan.keep_recordings)) {
    throw SettingsError(*in.find("keep_recordings"), "true or false is asked for");
  }
  if (!in.rest().empty()) throw missing(settings, "Batch", "holds no Section.key");

  std::vector<std::string> all_conditions{"plain"};
  if (conditions != nullptr) all_conditions = namesIn(*conditions);
  const std::vector<int> all_seeds = seeds != nullptr ? seedsIn(*seeds) : std::vector<int>{0};
  std::set<std::string> used;
  for (const std::string& name : namesIn(*sequences)) {
    plan.sequences.push_back(readSequence(settings, name, all_conditions, all_seeds));
    const std::vector<std::string>& of_it = plan.sequences.back().conditions;
    used.insert(of_it.begin(), of_it.end());
  }
  for (const std::string& name : used) plan.conditions.push_back(readCondition(settings, name));
  for (const std::string& name : namesIn(*names)) {
    plan.settings.push_back(readSetting(settings, name, ini));
  }
  if (plan.sequences.empty() || plan.settings.empty()) {
    throw missing(settings, "Batch", "names no sequence or no setting");
  }
  return plan;
}

std::string BatchRecording::row() const {
  return condition == nullptr ? sequence->name : sequence->name + "-" + condition->name;
}

std::string BatchRecording::name() const {
  return condition == nullptr ? row() : row() + "-" + std::to_string(seed);
}

std::vector<BatchRecording> recordingsOf(const BatchPlan& plan) {
  std::vector<BatchRecording> out;
  for (const BatchSequence& s : plan.sequences) {
    if (!s.rawlog.empty()) out.push_back({&s, nullptr, 0});
    for (const std::string& name : s.conditions) {
      const auto condition = std::find_if(plan.conditions.begin(), plan.conditions.end(),
                                          [&](const BatchCondition& c) { return c.name == name; });
      for (const int seed : s.seeds) out.push_back({&s, &*condition, seed});
    }
  }
  return out;
}

}  // namespace vir::app
