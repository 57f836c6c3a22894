#pragma once
/// Every field of a message, as deep as it goes.
#include "vir/bags/message_view.h"

namespace vir::fuzz {

inline void readFields(const bags::MessageView& m, int depth) {
  for (const bags::Field& f : m.type().fields) {
    try {
      if (f.type != nullptr && f.array) {
        int n = 0;
        m.each(f.name, [&](const bags::MessageView& e) {
          if (++n < 10 && depth < 4) readFields(e, depth + 1);
        });
      } else if (f.array) {
        m.numbers(f.name, 1000);
      } else if (f.kind == bags::Kind::text) {
        m.text(f.name);
      } else if (f.type != nullptr || f.kind == bags::Kind::time) {
        m.time(f.name);
      } else {
        m.number(f.name);
      }
    } catch (const bags::BagError&) {
    }
  }
}

}  // namespace vir::fuzz
