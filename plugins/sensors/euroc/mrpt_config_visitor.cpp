#include "mrpt_config_visitor.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "input_error.h"
#include "text_fields.h"

namespace vir::euroc {
namespace {

std::string lower(std::string s) {
  std::transform(s.begin(), s.end(), s.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return s;
}

/// MRPT keeps a comment behind a value as part of the text.
std::string withoutComment(std::string s) {
  for (const char* mark : {" //", " #", " ;", "\t//", "\t#", "\t;"}) {
    s = s.substr(0, s.find(mark));
  }
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.back()))) s.pop_back();
  return s;
}

}  // namespace

bool MrptConfigVisitor::text(const char* key, std::string* out) {
  known_.insert(lower(key));
  if (!config_.keyExists(section_, key)) return false;
  *out = withoutComment(config_.read_string(section_, key, ""));
  return true;
}

void MrptConfigVisitor::fail(const std::string& key, const std::string& value,
                             const std::string& wanted) const {
  throw InputError("[" + section_ + "] " + key + " = " + value + ": must be " + wanted);
}

double MrptConfigVisitor::number(const char* key, const std::string& text) const {
  double v = 0;
  if (!parseNumber(text, &v) || !std::isfinite(v)) fail(key, text, "a number");
  return v;
}

void MrptConfigVisitor::value(const char* key, bool& v, const char*) {
  std::string s;
  if (!text(key, &s)) return;
  const std::string word = lower(s);
  if (word == "true" || word == "yes" || word == "1") {
    v = true;
  } else if (word == "false" || word == "no" || word == "0") {
    v = false;
  } else {
    fail(key, s, "true or false");
  }
}

void MrptConfigVisitor::value(const char* key, int& v, Bounds<int> bounds, const char*) {
  std::string s;
  if (!text(key, &s)) return;
  const double x = number(key, s);
  if (x != std::floor(x) || x < bounds.min || x > bounds.max) {
    fail(key, s,
         "a whole number from " + std::to_string(bounds.min) + " to " + std::to_string(bounds.max));
  }
  v = static_cast<int>(x);
}

void MrptConfigVisitor::value(const char* key, double& v, Bounds<double> bounds, const char*) {
  std::string s;
  if (!text(key, &s)) return;
  const double x = number(key, s);
  if (x < bounds.min) fail(key, s, "at least " + std::to_string(bounds.min));
  if (x > bounds.max) fail(key, s, "at most " + std::to_string(bounds.max));
  v = x;
}

void MrptConfigVisitor::value(const char* key, std::string& v, const char*) {
  std::string s;
  if (text(key, &s)) v = s;
}

void MrptConfigVisitor::value(const char* key, std::vector<double>& v, std::size_t size,
                              const char*) {
  std::string s;
  if (!text(key, &s)) return;
  std::vector<std::string_view> fields;
  if (!s.empty()) splitFields(s, &fields);
  std::vector<double> out;
  for (const auto field : fields) out.push_back(number(key, std::string(field)));
  if (size != 0 && out.size() != size) fail(key, s, std::to_string(size) + " numbers");
  v = std::move(out);
}

void MrptConfigVisitor::choice(const char* key, std::string& v,
                               const std::vector<std::string>& allowed, const char*) {
  std::string s;
  if (!text(key, &s)) return;
  if (std::find(allowed.begin(), allowed.end(), s) == allowed.end()) {
    std::string words;
    for (const auto& a : allowed) words += (words.empty() ? "" : ", ") + a;
    fail(key, s, "one of " + words);
  }
  v = s;
}

void MrptConfigVisitor::requireAllKnown() const {
  static const std::set<std::string> kOfEverySensor = {"driver",          "process_rate",
                                                       "max_queue_len",   "sensorlabel",
                                                       "grab_decimation", "rawlog-grabber-ignore"};
  std::vector<std::string> keys;
  config_.getAllKeys(section_, keys);
  for (const std::string& key : keys) {
    if (known_.count(lower(key)) || kOfEverySensor.count(lower(key))) continue;
    std::string words;
    for (const auto& k : known_) words += (words.empty() ? "" : ", ") + k;
    throw InputError("[" + section_ + "] " + key + ": no such setting; known are " + words);
  }
}

}  // namespace vir::euroc
