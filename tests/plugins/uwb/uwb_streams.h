#pragma once
/// What devices send, for tests of the parsers.
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "range_parser.h"

namespace vir::uwb::test {

using Bytes = std::string;

inline void feed(RangeParser* parser, std::string_view bytes, std::vector<RangeReading>* out) {
  parser->feed(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), out);
}

struct Parsed {
  std::vector<RangeReading> readings;
  ParserCounters counters;
  std::size_t buffered = 0;
};

/// Fed at once, or in pieces of `piece` bytes.
inline Parsed parse(const std::string& protocol, std::string_view bytes, std::size_t piece = 0,
                    const RangeLimits& limits = {}) {
  const auto parser = makeParser(protocol, limits);
  Parsed p;
  if (piece == 0) piece = bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    feed(parser.get(), bytes.substr(at, piece), &p.readings);
  }
  p.counters = parser->counters();
  p.buffered = parser->buffered();
  return p;
}

/// Protocol name and the ranges as "id=m" words.
inline std::string shown(const std::vector<RangeReading>& readings) {
  std::string text;
  char word[64];
  for (const RangeReading& r : readings) {
    std::snprintf(word, sizeof word, "%lld=%.3f ", static_cast<long long>(r.responder), r.range_m);
    text += word;
  }
  return text;
}

inline void put(Bytes* b, std::uint64_t v, int bytes) {
  for (int i = 0; i < bytes; ++i) b->push_back(static_cast<char>(v >> (8 * i)));
}

inline void seal(Bytes* b) {
  unsigned sum = 0;
  for (const char c : *b) sum += static_cast<unsigned char>(c);
  b->push_back(static_cast<char>(sum));
}

/// NLink NodeFrame3 with nodes (id, mm).
inline Bytes nodeFrame3(const std::vector<std::pair<int, int>>& nodes, std::uint32_t ms = 5000) {
  Bytes b("\x55\x05", 2);
  put(&b, 21 + 7 * nodes.size() + 1, 2);
  put(&b, 2, 1);       // role: tag
  put(&b, 9, 1);       // id
  put(&b, ms, 4);      // local time
  put(&b, ms + 7, 4);  // system time
  put(&b, 0, 4);
  put(&b, 4900, 2);  // voltage
  put(&b, nodes.size(), 1);
  for (const auto& [id, mm] : nodes) {
    put(&b, 1, 1);
    put(&b, static_cast<std::uint64_t>(id), 1);
    put(&b, static_cast<std::uint64_t>(mm), 3);
    put(&b, 160, 1);  // first path -80 dBm
    put(&b, 156, 1);  // -78 dBm
  }
  seal(&b);
  return b;
}

inline Bytes nodeFrame2(const std::vector<std::pair<int, int>>& nodes, std::uint32_t ms = 5000) {
  Bytes b("\x55\x04", 2);
  put(&b, 119 + 13 * nodes.size() + 1, 2);
  put(&b, 2, 1);
  put(&b, 9, 1);
  put(&b, ms, 4);
  while (b.size() < 118) b.push_back(0);
  put(&b, nodes.size(), 1);
  for (const auto& [id, mm] : nodes) {
    put(&b, 1, 1);
    put(&b, static_cast<std::uint64_t>(id), 1);
    put(&b, static_cast<std::uint64_t>(mm), 3);
    put(&b, 190, 1);  // first path -95 dBm
    put(&b, 160, 1);  // -80 dBm: a gap of 15 dB
    put(&b, ms, 4);
    put(&b, 0, 2);
  }
  seal(&b);
  return b;
}

inline Bytes nodeFrame5(std::uint32_t id, int mm) {
  Bytes b("\x55\x08", 2);
  put(&b, 24 + 10 + 1, 2);
  put(&b, 2, 1);
  put(&b, 77, 4);
  put(&b, 6000, 4);
  put(&b, 6007, 4);
  put(&b, 0, 4);
  put(&b, 4900, 2);
  put(&b, 1, 1);
  put(&b, 1, 1);
  put(&b, id, 4);
  put(&b, static_cast<std::uint64_t>(mm), 3);
  put(&b, 160, 1);
  put(&b, 156, 1);
  seal(&b);
  return b;
}

inline Bytes tagFrame0(const std::vector<int>& mm, std::uint32_t ms = 5000) {
  Bytes b("\x55\x01", 2);
  put(&b, 3, 1);  // id
  put(&b, 2, 1);  // role
  while (b.size() < 22) b.push_back(0);
  for (std::size_t i = 0; i < 8; ++i) {
    put(&b, i < mm.size() ? static_cast<std::uint64_t>(mm[i]) : 0, 3);
  }
  const float inertial[6] = {0.01F, -0.02F, 0.003F, 0.1F, 0.2F, 9.8F};
  for (const float v : inertial) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &v, 4);
    put(&b, bits, 4);
  }
  while (b.size() < 108) b.push_back(0);
  put(&b, ms, 4);
  put(&b, ms, 4);
  while (b.size() < 127) b.push_back(0);
  seal(&b);
  return b;
}

/// DWM1001 binary answer with anchors (id, mm).
inline Bytes tlvAnswer(const std::vector<std::pair<int, int>>& anchors) {
  Bytes b("\x40\x01\x00\x41\x0D", 5);
  put(&b, 6950, 4);
  put(&b, 5370, 4);
  put(&b, static_cast<std::uint32_t>(-1970), 4);
  put(&b, 52, 1);
  put(&b, 0x49, 1);
  put(&b, 1 + 20 * anchors.size(), 1);
  put(&b, anchors.size(), 1);
  for (const auto& [id, mm] : anchors) {
    put(&b, static_cast<std::uint64_t>(id), 2);
    put(&b, static_cast<std::uint64_t>(mm), 4);
    put(&b, 100, 1);
    for (int i = 0; i < 12; ++i) b.push_back(static_cast<char>(i));
    put(&b, 100, 1);
  }
  return b;
}

struct Stream {
  std::string protocol;
  Bytes bytes;
  std::string ranges;  ///< as shown()
};

/// One good stream per protocol, among it lines that give no range.
inline std::vector<Stream> goodStreams() {
  return {
      {"dwm1001",
       "dwm> lec\r\n"
       "DIST,2,AN0,022E,7.94,8.03,0.00,3.44,AN1,15BA,0.00,8.00,0.00,2.12,POS,6.95,5.37,-1.97,52\r\n"
       "DIST,1,AN0,15BA,0.00,8.00,0.00,2.15\r\n"
       "022E[7.94,8.03,0.00]=3.38 15BA[0.00,8.00,0.00]=2.17 le_us=3082 est[6.95,5.37,-1.97,52]\r\n",
       "558=3.440 5562=2.120 5562=2.150 558=3.380 5562=2.170 "},
      {"dwm1001_tlv", tlvAnswer({{0x022E, 3440}, {0x15BA, 2120}}) + tlvAnswer({{0x15BA, 2150}}),
       "558=3.440 5562=2.120 5562=2.150 "},
      {"trek1000",
       "mc 0f 00000663 000005a3 00000512 000004cb 095f c1 00024bed a0:0\r\n"
       "mr 0f 00000663 000005a3 00000512 000004cb 095f c1 40424042 a0:0\r\n"
       "ma 07 00000000 0000085c 00000659 000006b7 095f 26 00024bed a0:0\r\n"
       "mc 02 00000000 00000700 00000000 00000000 0960 c2 00024c1f t3:1 \n",
       "0=1.635 1=1.443 2=1.298 3=1.227 1=1.792 "},
      {"at_range",
       "AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0,0,0,0,0),rssi:(-79.31,0.00,0.00,0.00,0.00,"
       "0.00,0.00,0.00)\r\n"
       "AT+RANGE=tid:1, mask:0x0F, seq:66, range:(192,201,150,300), ancid:(4,5,6,7)\r\n",
       "0=0.920 4=1.920 5=2.010 6=1.500 7=3.000 "},
      {"qm33",
       "SESSION_INFO_NTF: {session_handle=1, sequence_number=1, block_index=1, n_measurements=2\n"
       " [mac_address=0x0001, status=\"SUCCESS\", distance[cm]=245];\n"
       " [mac_address=0x0002, status=\"RX_TIMEOUT\"]}\n"
       "SESSION_INFO_NTF: {session_handle=1, sequence_number=2, block_index=2, n_measurements=1 "
       "[mac_address=0x0002, status=\"SUCCESS\", distance[cm]=301, RSSI[dBm]=-65.5]}\n",
       "1=2.450 2=3.010 "},
      {"nlink",
       nodeFrame3({{1, 2345}, {2, 6789}}) + nodeFrame2({{3, 1500}}) + tagFrame0({1000, 2000}) +
           nodeFrame5(70000, 4321),
       "1=2.345 2=6.789 3=1.500 0=1.000 1=2.000 70000=4.321 "},
      {"dw1000_arduino",
       "### TAG ###\r\n"
       "from: 0xE29C\tRange: 1.484 m\tRX power: -67.19 dBm\r\n"
       "from: 1782\t Range: 0.73 m\t RX power: -70.02 dBm\r\n",
       "58012=1.484 6018=0.730 "},
      {"json",
       "{\"utime\":1234567,\"uid\":4660,\"ouid\":22136,\"raz\":[1.484],\"rssi\":[-79.3],\"los\":[1."
       "0]}\n"
       "{\"utime\": 1300000, \"uid\": 4660, \"ouid\": 3, \"raz\": [2.5, 0.1, 0.2]}\r\n",
       "22136=1.484 3=2.500 "}};
}

}  // namespace vir::uwb::test
