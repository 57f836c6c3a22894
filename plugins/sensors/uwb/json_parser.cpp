#include "json_parser.h"

#include <nlohmann/json.hpp>
#include <set>

namespace vir::uwb {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxMicroseconds = std::int64_t{1} << 52;

/// Parses an object; false if it is none or holds a key twice.
bool parseObject(std::string_view line, json* object) {
  std::set<std::string> keys;
  bool repeated = false;
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::key && depth == 1) {
      repeated |= !keys.insert(parsed.get<std::string>()).second;
    }
    return true;
  };
  *object = json::parse(line.begin(), line.end(), watch, false);
  return object->is_object() && !repeated;
}

bool wholeNumber(const json& object, const char* key, std::int64_t* value) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number_integer()) return false;
  if (it->is_number_unsigned() && it->get<std::uint64_t>() > INT64_MAX) return false;
  *value = it->get<std::int64_t>();
  return *value >= 0;
}

/// The first element of an array of numbers; true with `value` left empty where there is none.
bool firstNumber(const json& object, const char* key, std::optional<double>* value) {
  const auto it = object.find(key);
  if (it == object.end()) return true;
  if (!it->is_array()) return false;
  for (const json& item : *it) {
    if (!item.is_number() && !item.is_null()) return false;
  }
  if (!it->empty() && it->front().is_number()) *value = it->front().get<double>();
  return true;
}

}  // namespace

LineRangeParser::Verdict JsonParser::parseLine(std::string_view line,
                                               std::vector<RangeReading>* out) {
  const bool torn = line.find("\"raz\"") != line.npos || line.find("\"tdoa\"") != line.npos;
  if (line.front() != '{') return torn ? Verdict::corrupt : Verdict::other;
  json object;
  if (!parseObject(line, &object)) return Verdict::corrupt;
  const bool difference = object.contains("tdoa");
  if (!difference && !object.contains("raz")) return Verdict::ignored;
  if (difference && object.contains("raz")) return Verdict::corrupt;
  RangeReading reading;
  std::int64_t own = 0, microseconds = 0;
  std::optional<double> range_m, los;
  if (!wholeNumber(object, "ouid", &reading.responder) ||
      !firstNumber(object, difference ? "tdoa" : "raz", &range_m) ||
      !firstNumber(object, "los", &los) || !firstNumber(object, "rssi", &reading.rssi_dbm)) {
    return Verdict::corrupt;
  }
  if (object.contains("uid")) {
    if (!wholeNumber(object, "uid", &own)) return Verdict::corrupt;
    reading.own = own;
  }
  if (object.contains("utime")) {
    if (!wholeNumber(object, "utime", &microseconds) || microseconds > kMaxMicroseconds) {
      return Verdict::corrupt;
    }
    reading.device_time = microseconds * 1000;
  }
  if (difference) {
    std::int64_t reference = 0;
    if (!wholeNumber(object, "ruid", &reference) || reference == reading.responder) {
      return Verdict::corrupt;
    }
    if (range_m) reading.reference = reference;  // else it was not measured
  }
  if (los) reading.line_of_sight = *los > 0.5;
  reading.range_m = range_m.value_or(0);
  give(reading, out);
  return Verdict::message;
}

}  // namespace vir::uwb
