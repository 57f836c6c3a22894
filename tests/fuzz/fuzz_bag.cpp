/// Any bytes, or damage to a good file, as a bag: no harm, no more memory than the file may need,
/// every message read by its definition. One program per kind (VIR_FUZZ_BAG):
///   VIR_FUZZ_BYTES=10000000 fuzz_bag_ros1_lz4 -max_len=256
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "fuzz_damage.h"
#include "fuzz_memory.h"
#include "fuzz_message_fields.h"

namespace {

using vir::bags::BagError;
using vir::bags::MessageView;

std::string goodFile() {
  std::ifstream file(VIR_FUZZ_FILE, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = goodFile();
  if (good.empty()) std::abort();
  const std::string bytes = vir::fuzz::input(data, size, good);
  // A copy of its own, so that reading beyond its end is noticed.
  const vir::bags::Bytes file(bytes.begin(), bytes.end());
  // A chunk may unpack to 64 MB whatever its size (and is copied while its buffer grows).
  const vir::fuzz::MemoryWatch watch(bytes.size(), 4, 192 << 20);
  try {
    const auto reader = vir::bags::openBag({file.data(), file.size()}, "fuzz");
    vir::bags::BagMessage message;
    while (reader->next(&message)) {
      try {
        const auto definition = vir::bags::Definition::of(*message.channel);
        vir::fuzz::readFields(MessageView(*definition, message.data), 0);
      } catch (const BagError&) {
      }
    }
  } catch (const BagError&) {
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
