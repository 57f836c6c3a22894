/// Any bytes, or damage to a good file, as a bag: no harm, no more memory than the file may need,
/// every message read by its definition. One program per kind (VIR_FUZZ_BAG):
///   VIR_FUZZ_BYTES=10000000 fuzz_bag_ros1_lz4 -max_len=256
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "fuzz_damage.h"
#include "vir/bags/message_view.h"

namespace {

using vir::bags::BagError;
using vir::bags::MessageType;
using vir::bags::MessageView;

/// Every field of a message, as deep as it goes.
void readFields(const MessageView& m, int depth) {
  for (const vir::bags::Field& f : m.type().fields) {
    try {
      if (f.type != nullptr && f.array) {
        int n = 0;
        m.each(f.name, [&](const MessageView& e) {
          if (++n < 10 && depth < 4) readFields(e, depth + 1);
        });
      } else if (f.array) {
        m.numbers(f.name, 1000);
      } else if (f.kind == vir::bags::Kind::text) {
        m.text(f.name);
      } else if (f.type != nullptr || f.kind == vir::bags::Kind::time) {
        m.time(f.name);
      } else {
        m.number(f.name);
      }
    } catch (const BagError&) {
    }
  }
}

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
  try {
    const auto reader = vir::bags::openBag({file.data(), file.size()}, "fuzz");
    vir::bags::BagMessage message;
    while (reader->next(&message)) {
      try {
        const auto definition = vir::bags::Definition::of(*message.channel);
        readFields(MessageView(*definition, message.data), 0);
      } catch (const BagError&) {
      }
    }
  } catch (const BagError&) {
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
