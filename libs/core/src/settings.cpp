#include "vir/core/settings.h"

#include <mrpt/config/CConfigFileBase.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "ini_text.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"

namespace vir {
inline namespace core {
namespace {

std::string message(const SettingOrigin& origin, const std::string& section, const std::string& key,
                    const std::string& problem) {
  std::string text = origin.file;
  if (origin.line > 0) text += ":" + std::to_string(origin.line);
  text += ": ";
  if (!section.empty()) text += "[" + section + "] ";
  if (!key.empty()) text += key + ": ";
  return text + problem;
}

/// No ini is as large as this [byte].
constexpr std::size_t kLargestIni = 16'000'000;

std::string readWhole(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw SettingsError({path, 0}, "", "", "there is no such settings file");
  }
  const std::string other = notAFile(path);
  if (!other.empty()) {
    throw SettingsError({path, 0}, "", "", "this is " + other + ", not a settings file");
  }
  try {
    return readTextFile(path, kLargestIni);
  } catch (const std::runtime_error& e) {
    throw SettingsError({path, 0}, "", "",
                        std::string("cannot read the settings file: ") + e.what());
  }
}

bool same(const std::string& a, const std::string& b) { return lowerCase(a) == lowerCase(b); }

std::string sectionNameIn(const std::string& line, const SettingOrigin& origin) {
  const std::size_t end = line.find(']');
  const std::string name = end == std::string::npos ? "" : ini::trim(line.substr(1, end - 1));
  const bool clean =
      end != std::string::npos && ini::withoutComment(" " + line.substr(end + 1)).empty();
  if (name.empty() || !clean) {
    throw SettingsError(origin, "", "",
                        "malformed section line '" + ini::shown(line) + "'; expected [Name]");
  }
  return name;
}

}  // namespace

SettingsError::SettingsError(SettingOrigin origin, std::string section, std::string key,
                             const std::string& problem)
    : std::runtime_error(message(origin, section, key, problem)),
      origin_(std::move(origin)),
      section_(std::move(section)),
      key_(std::move(key)) {}

SettingsError::SettingsError(const Setting& s, const std::string& problem)
    : std::runtime_error(
          message(s.origin, s.section, s.key + " = " + ini::shown(s.value), problem)),
      origin_(s.origin),
      section_(s.section),
      key_(s.key) {}

Settings Settings::fromFile(const std::string& path) { return fromText(readWhole(path), path); }

Settings Settings::fromText(const std::string& text, const std::string& name) {
  Settings settings;
  settings.name_ = name;
  bool in_section = false;
  std::string section;
  for (const ini::Line& line : ini::expandedLines(text, name)) {
    const SettingOrigin origin{name, line.number};
    const std::string content = ini::withoutComment(line.text);
    if (content.empty()) continue;
    if (content[0] == '[') {
      section = sectionNameIn(content, origin);
      in_section = true;
      if (!settings.hasSection(section)) settings.sections_.emplace_back(section, origin);
      continue;
    }
    const std::size_t equals = content.find('=');
    const std::string key = equals == std::string::npos ? "" : ini::trim(content.substr(0, equals));
    if (key.empty()) {
      throw SettingsError(origin, section, "",
                          "malformed line '" + ini::shown(content) + "'; expected key = value");
    }
    if (!in_section) {
      throw SettingsError(origin, "", key, "stands before the first [Section]");
    }
    if (const Setting* first = settings.find(section, key)) {
      throw SettingsError(origin, section, key,
                          "repeated; first set on line " + std::to_string(first->origin.line) +
                              ". Remove one of the two");
    }
    settings.settings_.push_back({section, key, ini::trim(content.substr(equals + 1)), origin});
  }
  if (settings.settings_.empty()) {
    throw SettingsError({name, 0}, "", "", "there is no setting in this file");
  }
  return settings;
}

Settings Settings::fromMrpt(const mrpt::config::CConfigFileBase& config, const std::string& section,
                            const std::string& name) {
  Settings settings;
  settings.name_ = name;
  settings.sections_.emplace_back(section, SettingOrigin{name, 0});
  std::vector<std::string> keys;
  config.getAllKeys(section, keys);
  for (const std::string& key : keys) {
    const std::string value = ini::withoutComment(config.read_string(section, key, ""));
    settings.settings_.push_back({section, key, value, {name, 0}});
  }
  return settings;
}

void Settings::set(const std::string& assignment) {
  const SettingOrigin origin{"--set", 0};
  const std::size_t equals = assignment.find('=');
  const std::string left = assignment.substr(0, std::min(equals, assignment.size()));
  const std::size_t dot = left.find('.');
  const std::string section = ini::trim(left.substr(0, std::min(dot, left.size())));
  const std::string key = dot == std::string::npos ? "" : ini::trim(left.substr(dot + 1));
  if (equals == std::string::npos || section.empty() || key.empty()) {
    throw SettingsError(origin, "", "",
                        "'" + ini::shown(assignment) + "' is not of the form Section.key=value");
  }
  const std::string value = ini::trim(assignment.substr(equals + 1));
  if (!hasSection(section)) sections_.emplace_back(section, origin);
  for (Setting& setting : settings_) {
    if (!same(setting.section, section) || !same(setting.key, key)) continue;
    setting.value = value;
    setting.origin = origin;
    return;
  }
  settings_.push_back({section, key, value, origin});
}

void Settings::eraseKey(const std::string& key) {
  const auto named = [&key](const Setting& s) { return same(s.key, key); };
  settings_.erase(std::remove_if(settings_.begin(), settings_.end(), named), settings_.end());
}

std::size_t Settings::mergeDefaults(const Settings& other) {
  std::size_t taken = 0;
  for (const auto& [section, origin] : other.sections_) {
    if (!hasSection(section)) sections_.emplace_back(section, origin);
  }
  for (const Setting& setting : other.settings_) {
    if (find(setting.section, setting.key) != nullptr) continue;
    settings_.push_back(setting);
    ++taken;
  }
  return taken;
}

std::vector<std::string> Settings::sections() const {
  std::vector<std::string> names;
  for (const auto& section : sections_) names.push_back(section.first);
  return names;
}

std::vector<std::string> Settings::keys(const std::string& section) const {
  std::vector<std::string> names;
  for (const Setting& setting : settings_) {
    if (same(setting.section, section)) names.push_back(setting.key);
  }
  return names;
}

bool Settings::hasSection(const std::string& section) const {
  return std::any_of(sections_.begin(), sections_.end(),
                     [&](const auto& s) { return same(s.first, section); });
}

const Setting* Settings::find(const std::string& section, const std::string& key) const {
  for (const Setting& setting : settings_) {
    if (same(setting.section, section) && same(setting.key, key)) return &setting;
  }
  return nullptr;
}

}  // namespace core
}  // namespace vir
