#pragma once
/// Strict ini settings. The syntax is MRPT's (rawlog-grabber reads the same files): comments with
/// `//`, `;` or `#`, `@define NAME value` and `${NAME}`, `$eval{}`, `$env{}`, lines continued with
/// a backslash, names not case-sensitive. What MRPT passes over in silence is an error here.
#include <cstddef>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/options.h"

namespace mrpt::config {
class CConfigFileBase;
}

namespace vir {
inline namespace core {

/// Where a setting was read.
struct SettingOrigin {
  std::string file;  ///< as given by the user, or "--set"
  int line = 0;      ///< 1-based, 0 where there is none
};

struct Setting {
  std::string section, key;  ///< as written
  std::string value;         ///< expanded, trimmed, without comment
  SettingOrigin origin;
};

/// what(): `FILE:LINE: [Section] key = value: what is wrong; what is allowed`.
class SettingsError : public std::runtime_error {
 public:
  SettingsError(SettingOrigin origin, std::string section, std::string key,
                const std::string& problem);
  /// For a value that cannot be: names it too.
  SettingsError(const Setting& setting, const std::string& problem);
  const SettingOrigin& origin() const { return origin_; }
  const std::string& section() const { return section_; }
  const std::string& key() const { return key_; }

 private:
  SettingOrigin origin_;
  std::string section_, key_;
};

/// The settings of one run: a file, what --set changes in it, and defaults from a second file.
class Settings {
 public:
  /// No settings at all: every option keeps its default.
  Settings() = default;
  /// Throws SettingsError: file missing, unreadable or without any setting; a malformed line; a
  /// key outside a section; a repeated key.
  static Settings fromFile(const std::string& path);
  /// The same from text; `name` stands for the file in messages.
  static Settings fromText(const std::string& text, const std::string& name);
  /// One section of an MRPT configuration, for a sensor that rawlog-grabber configures. MRPT keeps
  /// no line numbers and no repeated keys.
  static Settings fromMrpt(const mrpt::config::CConfigFileBase& config, const std::string& section,
                           const std::string& name);

  /// `Section.key=value` from the command line; replaces what the file says. Throws SettingsError
  /// for text of another form.
  void set(const std::string& assignment);
  /// Forgets every setting of this name, whatever its section.
  void eraseKey(const std::string& key);
  /// Takes over the settings of `other` that are not set here; returns how many.
  std::size_t mergeDefaults(const Settings& other);

  /// The file's name as given.
  const std::string& name() const { return name_; }
  /// In order of first appearance.
  std::vector<std::string> sections() const;
  std::vector<std::string> keys(const std::string& section) const;
  bool hasSection(const std::string& section) const;
  /// nullptr if not set. Names are not case-sensitive.
  const Setting* find(const std::string& section, const std::string& key) const;
  const std::vector<Setting>& all() const { return settings_; }

 private:
  std::string name_ = "settings";
  std::vector<Setting> settings_;
  std::vector<std::pair<std::string, SettingOrigin>> sections_;
  friend class SettingsReader;
};

/// Reads options from settings. Throws SettingsError for a value that is not exactly of the kind
/// asked for or out of bounds.
class SettingsReader : public OptionVisitor {
 public:
  explicit SettingsReader(const Settings& settings) : settings_(settings) {}

  void section(const std::string& name, const std::string& doc) override;
  void value(const char* key, bool& v, const char* doc) override;
  void value(const char* key, int& v, Bounds<int> bounds, const char* doc) override;
  void value(const char* key, double& v, Bounds<double> bounds, const char* doc) override;
  void value(const char* key, std::string& v, const char* doc) override;
  void value(const char* key, std::vector<double>& v, std::size_t size, const char* doc) override;
  void choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
              const char* doc) override;

  /// The section belongs to somebody else: its keys are not checked by finish().
  void ignoreSection(const std::string& name);
  /// The file holds settings for several readers: what is unknown in it is passed over.
  void ignoreUnknownFrom(const std::string& file) { tolerant_file_ = file; }
  /// Throws SettingsError for a section nobody declared, or a key in a declared one that nobody
  /// asked for, with the nearest known name.
  void finish() const;

 private:
  const Setting* lookUp(const char* key);
  bool passedOver(const SettingOrigin& origin) const;

  const Settings& settings_;
  std::string section_, tolerant_file_;
  std::set<std::string> ignored_;                        // lower case
  std::set<std::string> declared_sections_;              // as declared
  std::set<std::pair<std::string, std::string>> known_;  // (lower-case section, key as declared)
};

}  // namespace core
}  // namespace vir
