#pragma once
/// The fuzzer's bytes as they are, or as damage to a good stream, which gets behind the checks at a
/// message's front. Counts what was fed: with VIR_FUZZ_BYTES set the program ends after so many.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace vir::fuzz {

inline std::string input(const std::uint8_t* data, std::size_t size, const std::string& good,
                         int copies = 2) {
  if (size == 0) return {};
  if ((data[0] & 3) == 0) return {reinterpret_cast<const char*>(data + 1), size - 1};
  std::string stream;
  for (int i = 0; i < copies; ++i) stream += good;
  for (std::size_t i = 1; i + 3 < size && !stream.empty(); i += 4) {
    const std::size_t at = (data[i] | data[i + 1] << 8) % stream.size();
    const char byte = static_cast<char>(data[i + 3]);
    switch (data[i + 2] % 4) {
      case 0:
        stream[at] = byte;
        break;
      case 1:
        stream.erase(at, 1 + data[i + 3] % 8);
        break;
      case 2:
        stream.insert(at, 1, byte);
        break;
      default:
        stream[at] = static_cast<char>(stream[at] ^ (1 << (data[i + 3] % 8)));
    }
  }
  return stream;
}

/// What was fed, told when the program ends well (scripts/fuzz.sh adds these lines up).
struct Fed {
  std::uint64_t bytes = 0, runs = 0;
  void tell() const {
    std::fprintf(stderr, "fed %llu bytes in %llu runs\n", static_cast<unsigned long long>(bytes),
                 static_cast<unsigned long long>(runs));
  }
  ~Fed() { tell(); }
};

inline void count(std::size_t bytes) {
  static const char* limit = std::getenv("VIR_FUZZ_BYTES");
  static Fed fed;
  fed.bytes += bytes;
  ++fed.runs;
  if (limit == nullptr || fed.bytes < std::strtoull(limit, nullptr, 10)) return;
  fed.tell();
  // Not exit(): libFuzzer takes that for a finding. What is to be cleared away is told to
  // at_quick_exit().
  std::quick_exit(0);
}

}  // namespace vir::fuzz
