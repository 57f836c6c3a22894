#include "messages.h"
#include "wire.h"

namespace vir::emulator {
namespace {

void seal(std::string* frame) {
  unsigned sum = 0;
  for (const char c : *frame) sum += static_cast<unsigned char>(c);
  put(frame, sum, 1);
}

}  // namespace

std::string encodeNlink(const RangeMessage& m) {
  require(m.items.size() <= 255, "a NodeFrame3 holds at most 255 nodes");
  std::string out("\x55\x05", 2);
  put(&out, 21 + 7 * m.items.size() + 1, 2);
  put(&out, 2, 1);
  put(&out, static_cast<std::uint64_t>(m.own_id), 1);
  const auto ms = static_cast<std::uint64_t>(m.device_time / 1000000);
  put(&out, ms, 4);
  put(&out, ms + 11, 4);
  put(&out, 0, 4);
  put(&out, 4900, 2);
  put(&out, m.items.size(), 1);
  for (const RangeItem& item : m.items) {
    require(item.id >= 0 && item.id < 256, "LinkTrack ids of NodeFrame3 go to 255");
    put(&out, 1, 1);
    put(&out, static_cast<std::uint64_t>(item.id), 1);
    put(&out, static_cast<std::uint64_t>(rounded(item.range_m * 1000)), 3);
    put(&out, 160, 1);
    put(&out, 156, 1);
  }
  seal(&out);
  return out;
}

std::string encodeNlinkData(const DataMessage& m) {
  require(m.bytes.size() <= 1024, "a node sends at most 1024 bytes at once");
  require(m.sender >= 0 && m.sender < 256, "LinkTrack ids of NodeFrame0 go to 255");
  std::string out("\x55\x02", 2);
  put(&out, 11 + 4 + m.bytes.size() + 1, 2);
  put(&out, 2, 1);
  put(&out, static_cast<std::uint64_t>(m.own_id), 1);
  put(&out, 0, 4);
  put(&out, 1, 1);
  put(&out, 2, 1);
  put(&out, static_cast<std::uint64_t>(m.sender), 1);
  put(&out, m.bytes.size(), 2);
  out += m.bytes;
  seal(&out);
  return out;
}

}  // namespace vir::emulator
