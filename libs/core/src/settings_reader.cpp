#include <cmath>

#include "ini_text.h"
#include "vir/core/nearest.h"
#include "vir/core/parse_number.h"
#include "vir/core/settings.h"
#include "vir/core/text.h"

namespace vir {
inline namespace core {
namespace {

[[noreturn]] void refuse(const Setting& s, const std::string& problem, const std::string& allowed) {
  throw SettingsError(s, problem + "; allowed: " + allowed);
}

std::string listedNames(const std::vector<std::string>& names) {
  return names.empty() ? std::string("none") : ini::joined(names);
}

}  // namespace

void SettingsReader::section(const std::string& name, const std::string&) {
  section_ = name;
  declared_sections_.insert(name);
}

const Setting* SettingsReader::lookUp(const char* key) {
  known_.insert({lowerCase(section_), key});
  return settings_.find(section_, key);
}

void SettingsReader::value(const char* key, bool& v, const char*) {
  const Setting* s = lookUp(key);
  if (s == nullptr) return;
  if (!parseBool(s->value, &v)) refuse(*s, "not a yes or no", "true, false, yes, no, 1, 0");
}

void SettingsReader::value(const char* key, int& v, Bounds<int> bounds, const char*) {
  const Setting* s = lookUp(key);
  if (s == nullptr) return;
  // By way of a double, because $eval{} writes every result as one (1.500000e+01).
  double number = 0;
  if (!parseFinite(s->value, &number) || number != std::floor(number)) {
    refuse(*s, "not a whole number", ini::allowedText(bounds));
  }
  if (number < bounds.min || number > bounds.max) {
    refuse(*s, "out of bounds", ini::allowedText(bounds));
  }
  v = static_cast<int>(number);
}

void SettingsReader::value(const char* key, double& v, Bounds<double> bounds, const char*) {
  const Setting* s = lookUp(key);
  if (s == nullptr) return;
  double number = 0;
  if (!parseFinite(s->value, &number)) refuse(*s, "not a number", ini::allowedText(bounds));
  if (number < bounds.min || number > bounds.max) {
    refuse(*s, "out of bounds", ini::allowedText(bounds));
  }
  v = number;
}

void SettingsReader::value(const char* key, std::string& v, const char*) {
  if (const Setting* s = lookUp(key)) v = s->value;
}

void SettingsReader::value(const char* key, std::vector<double>& v, std::size_t size, const char*) {
  const Setting* s = lookUp(key);
  if (s == nullptr) return;
  std::vector<double> numbers;
  std::string rest = s->value;
  while (!rest.empty()) {
    const std::size_t end = rest.find_first_of(" \t");
    const std::string word = rest.substr(0, end);
    double number = 0;
    if (!parseFinite(word, &number)) {
      refuse(*s, "'" + ini::shown(word) + "' is not a number", ini::allowedListText(size));
    }
    numbers.push_back(number);
    rest = end == std::string::npos ? "" : ini::trim(rest.substr(end));
  }
  if (size != 0 && numbers.size() != size) {
    refuse(*s, std::to_string(numbers.size()) + " numbers", ini::allowedListText(size));
  }
  v = std::move(numbers);
}

void SettingsReader::choice(const char* key, std::string& v,
                            const std::vector<std::string>& allowed, const char*) {
  const Setting* s = lookUp(key);
  if (s == nullptr) return;
  for (const std::string& word : allowed) {
    if (lowerCase(word) != lowerCase(s->value)) continue;
    v = word;
    return;
  }
  refuse(*s, "not one of the choices", ini::joined(allowed));
}

void SettingsReader::ignoreSection(const std::string& name) { ignored_.insert(lowerCase(name)); }

bool SettingsReader::passedOver(const SettingOrigin& origin) const {
  return !tolerant_file_.empty() && origin.file == tolerant_file_;
}

void SettingsReader::finish() const {
  std::set<std::string> declared;
  for (const std::string& name : declared_sections_) declared.insert(lowerCase(name));
  for (const auto& [name, origin] : settings_.sections_) {
    if (declared.count(lowerCase(name)) > 0 || ignored_.count(lowerCase(name)) > 0) continue;
    if (passedOver(origin)) continue;
    const std::vector<std::string> names(declared_sections_.begin(), declared_sections_.end());
    const std::string near = nearest(name, names);
    throw SettingsError(origin, name, "",
                        "unknown section" + (near.empty() ? "" : "; did you mean [" + near + "]?") +
                            " Known sections: " + listedNames(names));
  }
  for (const Setting& s : settings_.settings_) {
    const std::string section = lowerCase(s.section);
    if (ignored_.count(section) > 0 || passedOver(s.origin)) continue;
    std::vector<std::string> keys;
    bool known = false;
    for (const auto& [known_section, key] : known_) {
      if (known_section != section) continue;
      keys.push_back(key);
      known = known || lowerCase(key) == lowerCase(s.key);
    }
    if (known) continue;
    const std::string near = nearest(s.key, keys);
    throw SettingsError(s.origin, s.section, s.key,
                        near.empty() ? "unknown key. Known keys: " + listedNames(keys)
                                     : "unknown key; did you mean " + near + "?");
  }
}

}  // namespace core
}  // namespace vir
