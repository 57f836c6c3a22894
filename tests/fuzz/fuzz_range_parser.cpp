/// Any bytes, in any pieces: bounded memory, the same ranges however they are cut, none out of
/// limits. One program per protocol (VIR_FUZZ_PROTOCOL):
///   VIR_FUZZ_BYTES=10000000 fuzz_uwb_nlink -max_len=256
#include <cstring>

#include "fuzz_damage.h"
#include "range_parser.h"
#include "uwb_streams.h"

namespace {

constexpr std::size_t kMostHeld = 8 * 6000;  // `auto` holds what all protocols do

using vir::uwb::RangeReading;

std::vector<RangeReading> run(const std::string& bytes, std::size_t piece) {
  const auto parser = vir::uwb::makeParser(VIR_FUZZ_PROTOCOL, {});
  std::vector<RangeReading> readings;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    // A copy of its own, so that reading beyond its end is noticed.
    const std::vector<std::uint8_t> part(
        bytes.begin() + static_cast<std::ptrdiff_t>(at),
        bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at + piece, bytes.size())));
    parser->feed(part.data(), part.size(), &readings);
    if (parser->buffered() > kMostHeld) std::abort();
  }
  if (parser->counters().ranges != static_cast<long>(readings.size())) std::abort();
  for (const RangeReading& r : readings) {
    if (!(r.range_m >= 0.05 && r.range_m <= 300) || r.responder < 0) std::abort();
  }
  return readings;
}

/// Of the protocol; for `auto`, of two of them, so that one comes to the wrong parser.
std::string goodStream(std::size_t choice) {
  std::vector<std::string> streams;
  for (const auto& s : vir::uwb::test::goodStreams()) {
    const bool any = std::strcmp(VIR_FUZZ_PROTOCOL, "auto") == 0;
    if (any || s.protocol == VIR_FUZZ_PROTOCOL) streams.push_back(s.bytes);
  }
  if (streams.empty()) return {};
  const std::size_t n = streams.size();
  return streams[choice % n] + (n > 1 ? streams[(choice / n) % n] : "");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::size_t choice = size > 1 ? data[0] / 4 : 0;
  const std::string bytes = vir::fuzz::input(data, size, goodStream(choice));
  const auto whole = run(bytes, bytes.size() + 1);
  const auto pieces = run(bytes, size % 11 + 1);
  if (whole.size() != pieces.size()) std::abort();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i].responder != pieces[i].responder || whole[i].range_m != pieces[i].range_m) {
      std::abort();
    }
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
