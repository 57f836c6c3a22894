/// Any text as the definition of a message, any bytes as the message, in both wire formats: values
/// or BagError, and no more memory than four times what there is to read.
///   VIR_FUZZ_BYTES=10000000 fuzz_message -max_len=256
#include "fuzz_damage.h"
#include "fuzz_memory.h"
#include "fuzz_message_fields.h"
#include "vir/bags/mcap_writer.h"

namespace {

using namespace vir::bags;

struct Good {
  std::string type, definition, bytes;
};

/// An image, a transform (a list of messages) and a type with all that the language has.
const std::vector<Good>& goods() {
  static const std::vector<Good> all = [] {
    std::vector<Good> out;
    const auto keep = [&](const std::string& type, const std::string& definition,
                          const CdrWriter& w) {
      out.push_back({type, definition, std::string(w.bytes().begin(), w.bytes().end())});
    };
    CdrWriter image;
    image.time(1).text("cam").u32(2).u32(3).text("mono8").u8(0).u32(3).u32(6).raw("abcdef", 6);
    keep("sensor_msgs/Image", fullDefinition("sensor_msgs/Image", {}), image);
    CdrWriter tf;
    tf.u32(2);
    for (int i = 0; i < 2; ++i) {
      tf.time(i).text("a").text("b");
      for (int k = 0; k < 7; ++k) tf.f64(k);
    }
    keep("tf2_msgs/TFMessage", fullDefinition("tf2_msgs/TFMessage", {}), tf);
    CdrWriter mixed;
    mixed.u8(1).i32(-2).f64(0.5).u32(2).f32(1).f32(2).text("abc").u32(1).i64(7).u8(9);
    keep("pkg/A",
         "int32 X=4\nbool a\nint32 b\nfloat64 c\nfloat32[] d\nstring<=9 e\nB[] f\nuint8[1] g\n"
         "===\nMSG: pkg/B\nint64 k\n",
         mixed);
    return out;
  }();
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const Good& good = goods()[data[0] % goods().size()];
  const bool text_too = (data[1] & 1) != 0;
  const Wire wire = (data[1] & 2) != 0 ? Wire::cdr : Wire::ros1;
  const std::string definition =
      text_too ? vir::fuzz::input(data + 2, size - 2, good.definition) : good.definition;
  const std::string message =
      text_too && size % 2 == 0 ? good.bytes : vir::fuzz::input(data + 2, size - 2, good.bytes);
  const Bytes bytes(message.begin(), message.end());
  {
    // The types as they are kept are larger than their text: a field of three letters is a Field.
    const vir::fuzz::MemoryWatch watch(message.size() + 40 * definition.size(), 4, 1 << 20);
    try {
      const auto parsed = Definition::parse(good.type, definition, wire);
      vir::fuzz::readFields(MessageView(*parsed, {bytes.data(), bytes.size()}), 0);
    } catch (const BagError&) {
    }
  }
  vir::fuzz::count(message.size() + (text_too ? definition.size() : 0));
  return 0;
}
