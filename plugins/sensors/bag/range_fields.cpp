#include "range_fields.h"

#include <algorithm>
#include <cmath>

#include "input_error.h"
#include "vir/core/length_units.h"

namespace vir::bag {
namespace {

using bags::Field;
using bags::Kind;
using bags::MessageView;

constexpr std::size_t kMostRanges = 1000;

/// UTIL: the range to anchor idB less that to anchor idA.
constexpr const char* kUtilType = "cf_msgs/Tdoa";
constexpr const char* kOwnType = "vir_slam/Range";

struct Known {
  const char* type;
  const char *list, *anchor, *distance, *sigma;
  bool sigma_squared;
  const char *antenna, *place;
  double unit_m;
};

/// From the public definitions of these packages.
constexpr Known kKnown[] = {
    // NTU VIRAL: radios P440, several antennas on the robot
    {"uwb_driver/UwbRange", "", "responder_id", "distance", "", false, "rqst_antenna_offset",
     "responder_location", 1},
    // MILUV
    {"uwb_ros/RangeStamped", "", "to_id", "range", "covariance", true, "", "", 1},
    // UVIO and what its authors publish
    {"uwb_msgs/TwoWayRangeStamped", "", "UWB_ID2", "range_raw", "", false, "", "", 1},
    // Nooploop LinkTrack
    {"nlink_parser/LinktrackNodeframe2", "nodes", "id", "dis", "", false, "", "", 1},
    {"nlink_parser/LinktrackNodeframe3", "nodes", "id", "dis", "", false, "", "", 1},
    {"nlink_parser/LinktrackTagframe0", "", "", "dis_arr", "", false, "", "", 1},
    // GTEC: Pozyx and boards with DW1000
    {"gtec_msgs/Ranging", "", "anchorId", "range", "", false, "", "", 0.001},
    {"gtec_msgs/PozyxRanging", "", "destinationId", "range", "", false, "", "", 0.001},
    // What `export --format mcap` writes
    {kOwnType, "", "anchor", "range_m", "sigma_m", false, "antenna", "", 1},
    {kUtilType, "", "idB", "data", "", false, "", "", 1},
    {"sensor_msgs/Range", "", "", "range", "", false, "", "", 1},
};

/// `list[].field` into its two parts.
std::string splitList(std::string* path) {
  const std::size_t at = path->find("[].");
  if (at == std::string::npos) return {};
  const std::string list = path->substr(0, at);
  path->erase(0, at + 3);
  return list;
}

std::string wholeNumber(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", v);
  return text;
}

std::string anchorText(const MessageView& m, const std::string& path) {
  const Field* field = MessageView::typeOf(m.type(), path);
  if (field != nullptr && field->kind == Kind::text) return std::string(m.text(path));
  if (field != nullptr && field->kind == Kind::uint64) {
    return std::to_string(static_cast<std::uint64_t>(m.integer(path)));
  }
  return std::to_string(m.integer(path));
}

/// A Point.
std::optional<Vec3> pointIn(const MessageView& m, const std::string& path) {
  const Vec3 p(m.number(path + ".x"), m.number(path + ".y"), m.number(path + ".z"));
  return p.allFinite() ? std::optional<Vec3>(p) : std::nullopt;
}

void addCommon(const MessageView& m, const RangeFields& f, ReadRange* r) {
  // What somebody asked for and is not there is an error that names what is.
  if (!f.stamp.empty() && (f.asked || m.has(f.stamp))) {
    r->stamp = m.time(f.stamp);
    if (!r->stamp) {  // a number of seconds
      const double seconds = m.number(f.stamp);
      if (std::abs(seconds) < 9e9) r->stamp = fromSeconds(seconds);
    }
  }
  if (!f.sigma.empty() && (f.asked || m.has(f.sigma))) {
    const double s = m.number(f.sigma);
    if (std::isfinite(s) && s > 0) r->sigma_m = f.sigma_squared ? std::sqrt(s) : s;
  }
  if (!f.tag.empty() && (f.asked || m.has(f.tag))) r->tag = anchorText(m, f.tag);
  if (!f.antenna.empty() && (f.asked || m.has(f.antenna))) {
    const auto p = pointIn(m, f.antenna);
    if (p && p->norm() < 20) r->antenna = p;
  }
  if (!f.place.empty() && (f.asked || m.has(f.place))) r->place = pointIn(m, f.place);
}

/// The anchors of a list of distances, as text.
std::vector<std::string> anchorTexts(const MessageView& m, const std::string& path) {
  std::vector<std::string> out;
  const Field* field = MessageView::typeOf(m.type(), path);
  if (field != nullptr && field->kind == Kind::text) {
    for (const std::string_view text : m.texts(path, kMostRanges)) out.emplace_back(text);
  } else {
    for (const double number : m.numbers(path, kMostRanges)) out.push_back(wholeNumber(number));
  }
  return out;
}

/// A list of numbers: anchors are a list beside it, or its places.
void readList(const MessageView& m, const RangeFields& f, std::vector<ReadRange>* out) {
  const std::vector<double> distances = m.numbers(f.distance, kMostRanges);
  std::vector<std::string> anchors;
  if (!f.anchor.empty()) anchors = anchorTexts(m, f.anchor);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (!f.anchor.empty() && i >= anchors.size()) break;
    // In a list with a place for every anchor, 0 is one that did not answer.
    if (f.anchor.empty() && distances[i] == 0) continue;
    ReadRange r;
    r.anchor = f.anchor.empty() ? std::to_string(i) : anchors[i];
    r.range_m = distances[i] * f.unit_m;
    addCommon(m, f, &r);
    out->push_back(r);
  }
}

void readOne(const MessageView& m, const RangeFields& f, std::vector<ReadRange>* out) {
  if (!f.valid.empty() && m.number(f.valid) == 0) return;
  const Field* field = MessageView::typeOf(m.type(), f.distance);
  if (field != nullptr && field->array) {
    readList(m, f, out);
    return;
  }
  ReadRange r;
  r.anchor = f.fixed_anchor ? *f.fixed_anchor : anchorText(m, f.anchor);
  if (!f.name.empty() && m.has(f.name) && !m.text(f.name).empty()) r.anchor = m.text(f.name);
  if (!f.reference.empty()) r.reference = anchorText(m, f.reference);
  r.range_m = m.number(f.distance) * f.unit_m;
  addCommon(m, f, &r);
  out->push_back(r);
}

using Names = std::initializer_list<const char*>;

constexpr Names kAnchorNames = {
    "anchor_id",   "anchorId",    "anchorid",   "anchor",         "responder_id",
    "responderId", "to_id",       "toId",       "destination_id", "destinationId",
    "dest_id",     "dst_id",      "remote_id",  "node_id",        "network_id",
    "nodeId",      "anchor_name", "anchorName", "beacon_id",      "address",
    "addr",        "id"};
constexpr Names kDistanceNames = {"range",
                                  "distance",
                                  "dist",
                                  "dis",
                                  "range_m",
                                  "distance_m",
                                  "range_mm",
                                  "distance_mm",
                                  "dist_mm",
                                  "range_raw",
                                  "raw_range",
                                  "measured_range",
                                  "measured_distance",
                                  "value"};
constexpr Names kAnchorLists = {"anchors", "anchor_ids",      "anchor_id",
                                "ids",     "to_ids",          "destination_id",
                                "id",      "destination_ids", "responder_ids"};
constexpr Names kDistanceLists = {"ranges", "distances", "distance", "range", "dist", "data"};
constexpr Names kTagNames = {"tag",         "tag_id",     "tagId",   "tagid",        "requester_id",
                             "requesterId", "antenna_id", "from_id", "initiator_id", "mobile_id"};
constexpr Names kAntennaNames = {"tag_offset", "antenna_offset", "antenna_position", "lever_arm",
                                 "tag_position_body"};
constexpr Names kPlaceNames = {"anchor_position",    "anchor_location",    "anchor_pos",
                               "responder_position", "responder_location", "anchor_place"};
constexpr Names kValidNames = {"valid", "valid_range", "is_valid", "range_valid"};

// Of differences.
constexpr Names kFirstNames = {"reference", "reference_id", "ref_id",   "idA",    "id_a",
                               "anchor_a",  "anchorA",      "anchor_1", "from_id"};
constexpr Names kSecondNames = {"anchor",   "anchor_id", "idB",      "id_b",
                                "anchor_b", "anchorB",   "anchor_2", "to_id"};
constexpr Names kDifferenceNames = {"tdoa",      "data",     "difference", "range_difference",
                                    "diff",      "distance", "value",      "distance_diff",
                                    "range_diff"};

const Field* fieldNamed(const bags::MessageType& type, Names names, bool array) {
  for (const char* name : names) {
    for (const Field& f : type.fields) {
      if (f.name == name && f.array == array && f.type == nullptr && f.kind != Kind::time) {
        return &f;
      }
    }
  }
  return nullptr;
}

bool isReal(Kind k) { return k == Kind::float32 || k == Kind::float64; }

/// Units, and what a message without a header has in its place.
void addGuessedOptions(const bags::MessageType& type, const Field& distance, bool in_list,
                       std::vector<std::string>* out) {
  if (!isReal(distance.kind) || distance.name.find("_mm") != std::string::npos) {
    out->push_back("unit=mm");
  }
  if (in_list) return;
  bool header = false;
  for (const Field& f : type.fields) header = header || f.name == "header";
  for (const Field& f : type.fields) {
    const bool time =
        f.kind == Kind::time || (f.type != nullptr && f.type->name == "builtin_interfaces/Time");
    if (header || !time || f.array) continue;
    out->push_back("stamp=" + f.name);
    break;
  }
  const Field* valid = fieldNamed(type, kValidNames, false);
  if (valid != nullptr && valid->kind == Kind::boolean) out->push_back("valid=" + valid->name);
  const Field* tag = fieldNamed(type, kTagNames, false);
  if (tag != nullptr && !isReal(tag->kind) && tag->kind != Kind::boolean) {
    out->push_back("tag=" + tag->name);
  }
  for (const Field& f : type.fields) {
    const bool point =
        f.type != nullptr && !f.array &&
        (f.type->name == "geometry_msgs/Point" || f.type->name == "geometry_msgs/Vector3");
    const auto among = [&](Names names) {
      return point && std::find(names.begin(), names.end(), f.name) != names.end();
    };
    if (among(kAntennaNames)) out->push_back("antenna=" + f.name);
    if (among(kPlaceNames)) out->push_back("place=" + f.name);
  }
}

/// Anchor and distance of one message, or, where `array`, a list of each of them side by side.
std::vector<std::string> pairIn(const bags::MessageType& type, const std::string& list,
                                bool array) {
  const Field* anchor = fieldNamed(type, array ? kAnchorLists : kAnchorNames, array);
  const Field* distance = fieldNamed(type, array ? kDistanceLists : kDistanceNames, array);
  if (anchor == nullptr || distance == nullptr || distance->kind == Kind::text ||
      distance->kind == Kind::boolean || isReal(anchor->kind)) {
    return {};
  }
  std::vector<std::string> out{list + anchor->name, list + distance->name};
  addGuessedOptions(type, *distance, !list.empty(), &out);
  return out;
}

/// `unit=mm`, `stamp=field`, `sigma=field`, `valid=field`, `tag=field`, `antenna=field`,
/// `place=field`.
void applyOption(const std::string& topic, const std::string& option, RangeFields* f) {
  const std::size_t equals = option.find('=');
  const std::string key = option.substr(0, equals);
  std::string value = option.substr(equals + 1);
  // Within a list fields are those of its elements, however they are written.
  if (!f->list.empty() && value.rfind(f->list + "[].", 0) == 0) value.erase(0, f->list.size() + 3);
  f->asked = f->asked || key == "stamp" || key == "reference" || key == "sigma" || key == "tag" ||
             key == "antenna" || key == "place";
  if (key == "stamp") {
    f->stamp = value;
  } else if (key == "sigma") {
    f->sigma = value;
    f->sigma_squared = false;
  } else if (key == "valid") {
    f->valid = value;
  } else if (key == "tag") {
    f->tag = value;
  } else if (key == "antenna") {
    f->antenna = value;
  } else if (key == "place") {
    f->place = value;
  } else if (key == "reference") {
    f->reference = value;
  } else if (key == "unit" && lengthUnitOf(value)) {
    f->unit_m = *lengthUnitOf(value);
  } else {
    throw InputError(topic + ": `" + option + "` is not known; unit=" + kLengthUnitNames +
                     ", stamp=FIELD, sigma=FIELD, valid=FIELD, "
                     "tag=FIELD, antenna=FIELD, place=FIELD and reference=FIELD are");
  }
}

}  // namespace

bool isOwnRange(const std::string& type) { return type == kOwnType; }

std::optional<RangeFields> knownRangeFields(const std::string& type) {
  for (const Known& k : kKnown) {
    if (type != k.type) continue;
    RangeFields f;
    f.list = k.list;
    f.anchor = k.anchor;
    f.distance = k.distance;
    f.sigma = k.sigma;
    f.sigma_squared = k.sigma_squared;
    f.antenna = k.antenna;
    f.place = k.place;
    if (type == kOwnType) f.name = "anchor_name";
    if (type == kUtilType) {
      f.reference = "idA";
      f.stamp = "stamp";
    }
    f.unit_m = k.unit_m;
    return f;
  }
  return std::nullopt;
}

std::vector<std::string> guessRangeFields(const bags::MessageType& type) {
  std::vector<std::string> out = pairIn(type, "", false);
  for (const Field& f : type.fields) {
    if (out.empty() && f.array && f.type != nullptr) out = pairIn(*f.type, f.name + "[].", false);
  }
  return out.empty() ? pairIn(type, "", true) : out;
}

std::vector<std::string> guessDifferenceFields(const bags::MessageType& type) {
  const Field *first = fieldNamed(type, kFirstNames, false),
              *second = fieldNamed(type, kSecondNames, false),
              *distance = fieldNamed(type, kDifferenceNames, false);
  if (first == nullptr || second == nullptr || distance == nullptr || !isReal(distance->kind) ||
      isReal(first->kind) || isReal(second->kind)) {
    return {};
  }
  std::vector<std::string> out{second->name, distance->name, "reference=" + first->name};
  addGuessedOptions(type, *distance, false, &out);
  return out;
}

RangeFields rangeFieldsOf(const TopicWish& wish, const std::string& type,
                          const std::string& frame) {
  RangeFields f = knownRangeFields(type).value_or(RangeFields{});
  std::vector<std::string> places, options;
  for (const std::string& field : wish.fields) {
    (field.find('=') == std::string::npos ? places : options).push_back(field);
  }
  if (places.empty() && f.distance.empty()) {
    throw InputError(wish.topic + ": the type " + type +
                     " is no known one of ranges; say which of its fields are the anchor and the "
                     "distance: --topic range=" +
                     wish.topic + ":anchor_id,distance (`list[].field` within a list)");
  }
  if (!places.empty()) {
    if (places.size() != 2) {
      throw InputError(wish.topic + ": give two fields, anchor and distance, with a comma between");
    }
    f = RangeFields{};
    f.anchor = places[0];
    f.distance = places[1];
    f.list = splitList(&f.distance);
    const std::string other = splitList(&f.anchor);
    if (!f.anchor.empty() && f.anchor[0] == '#') {
      f.fixed_anchor = f.anchor.substr(1);
      f.anchor.clear();
    } else if (other != f.list) {
      throw InputError(wish.topic + ": anchor and distance must be fields of the same list");
    }
  } else if (type == "sensor_msgs/Range") {
    f.fixed_anchor = frame.empty() ? wish.topic : frame;
  }
  for (const std::string& option : options) applyOption(wish.topic, option, &f);
  return f;
}

std::vector<ReadRange> readRanges(const MessageView& message, const RangeFields& f) {
  std::vector<ReadRange> out;
  if (f.list.empty()) {
    readOne(message, f, &out);
  } else {
    message.each(f.list, [&](const MessageView& m) {
      if (out.size() < kMostRanges) readOne(m, f, &out);
    });
  }
  return out;
}

}  // namespace vir::bag
