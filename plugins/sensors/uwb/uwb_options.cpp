#include "uwb_options.h"

#include <sstream>
#include <stdexcept>

#include "vir/core/parse_number.h"

namespace vir::uwb {

void describe(OptionVisitor& v, UwbOptions& o) {
  v.section("uwb", "Ranges of a UWB device");
  v.value("port", o.source.port, "/dev/ttyACM0, tcp://host:port or udp://:port");
  v.value("baud", o.source.baud, {1200, 4000000}, "rate of a serial port");
  std::vector<std::string> protocols = {"auto"};
  protocols.insert(protocols.end(), protocolNames().begin(), protocolNames().end());
  v.choice("protocol", o.protocol, protocols, "what the device speaks; auto: recognise it");
  v.value("anchor_ids", o.anchor_ids, "ids of anchors (0x.. = hexadecimal), label = sensorLabel");
  v.value("peer_ids", o.peer_ids, "ids of other robots, label PEER");
  v.choice("unknown_ids", o.unknown_ids, {"drop", "anchor"},
           "what to do with ids in neither list (both empty: all are anchors)");
  v.value("own_id", o.own_id, {-1, 2147483647},
          "use only what the tag with this id measured; -1 = all");
  v.value("min_range_m", o.limits.min_m, {0, 1e5}, "shorter ranges are counted and dropped");
  v.value("max_range_m", o.limits.max_m, {0, 1e5}, "longer ranges are counted and dropped");
  v.value("std_error_m", o.std_error_m, {0, 100}, "standard deviation written with each range");
  v.value("antenna_m", o.antenna_m, 3, "the antenna in the body frame (body = IMU)");
  v.choice("stamp", o.stamp, {"auto", "arrival", "device"},
           "time of a range; auto: the device's own where its protocol documents it");
  v.value("latency_s", o.latency_s, {0, 10}, "taken off every stamp: from measuring to arrival");
  v.value("dialogue", o.dialogue, "ask a silent DWM1001 for its ranges");
  v.value("poll_hz", o.poll_hz, {0.1, 200}, "how often dwm1001_tlv is asked");
  v.value("tell_hz", o.tell_hz, {0, 50},
          "how often this robot's position goes to the others as data of the radio (nlink, with "
          "own_id; while estimating); 0 = never");
  v.value("silence_s", o.source.silence_s, {0, 3600},
          "report when nothing comes for so long (TCP: connect again); 0 = never");
}

std::set<std::int64_t> parseIds(const std::string& text) {
  std::string spaced = text;
  for (char& c : spaced) {
    if (c == ',') c = ' ';
  }
  std::istringstream words(spaced);
  std::set<std::int64_t> ids;
  for (std::string word; words >> word;) {
    const bool hex = word.size() > 2 && word[0] == '0' && (word[1] == 'x' || word[1] == 'X');
    std::int64_t id = -1;
    if (!parseNumber(word.substr(hex ? 2 : 0), &id, hex ? 16 : 10) || id < 0 || id > INT32_MAX) {
      throw std::invalid_argument("`" + word + "` is no id; write whole numbers, decimal or 0x..");
    }
    ids.insert(id);
  }
  return ids;
}

}  // namespace vir::uwb
