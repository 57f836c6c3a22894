#include "vir/core/ini_writer.h"

#include <charconv>

#include "ini_text.h"
#include "vir/core/text.h"

namespace vir {
inline namespace core {

std::string numberText(double v) {
  char buffer[40];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, v);
  return {buffer, result.ptr};
}

void IniWriter::section(const std::string& name, const std::string& doc) {
  for (current_ = 0; current_ < sections_.size(); ++current_) {
    if (lowerCase(sections_[current_].name) == lowerCase(name)) return;
  }
  sections_.push_back({name, doc, ""});
}

void IniWriter::add(const char* key, const std::string& value, const std::string& allowed,
                    const char* doc) {
  if (sections_.empty()) section("Settings", "");
  std::string& body = sections_[current_].body;
  if (style_ == Style::reference) {
    body += std::string("\n// ") + doc + "\n";
    if (!allowed.empty()) body += "// Allowed: " + allowed + ". Default: " + value + "\n";
  }
  body += std::string(key) + " = " + value + "\n";
}

void IniWriter::value(const char* key, bool& v, const char* doc) {
  add(key, v ? "true" : "false", "true, false", doc);
}

void IniWriter::value(const char* key, int& v, Bounds<int> bounds, const char* doc) {
  add(key, std::to_string(v), ini::allowedText(bounds), doc);
}

void IniWriter::value(const char* key, double& v, Bounds<double> bounds, const char* doc) {
  add(key, numberText(v), ini::allowedText(bounds), doc);
}

void IniWriter::value(const char* key, std::string& v, const char* doc) { add(key, v, "", doc); }

void IniWriter::value(const char* key, std::vector<double>& v, std::size_t size, const char* doc) {
  std::string text;
  for (const double number : v) text += (text.empty() ? "" : " ") + numberText(number);
  add(key, text, ini::allowedListText(size), doc);
}

void IniWriter::choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
                       const char* doc) {
  add(key, v, ini::joined(allowed), doc);
}

std::string IniWriter::text() const {
  std::string out;
  for (const Section& s : sections_) {
    if (!out.empty()) out += "\n";
    if (style_ == Style::reference && !s.doc.empty()) out += "// " + s.doc + "\n";
    out += "[" + s.name + "]\n" + s.body;
  }
  return out;
}

}  // namespace core
}  // namespace vir
