#include "frame_parser.h"

#include <algorithm>

namespace vir::uwb {

void FrameRangeParser::feed(const std::uint8_t* bytes, std::size_t size,
                            std::vector<RangeReading>* out) {
  // In pieces, so that no more than one frame and one piece is ever held.
  constexpr std::size_t kPiece = 1024;
  for (std::size_t done = 0; done < size;) {
    const std::size_t n = std::min(kPiece, size - done);
    buffer_.insert(buffer_.end(), bytes + done, bytes + done + n);
    done += n;
    std::size_t at = 0;
    while (at < buffer_.size()) {
      const Look found = look(buffer_.data() + at, buffer_.size() - at);
      if (found.outcome == Outcome::need_more && buffer_.size() - at < kLongestFrame) break;
      if (found.outcome == Outcome::frame) {
        parseFrame(buffer_.data() + at, found.size, out);
        at += found.size;
        continue;
      }
      if (found.outcome == Outcome::corrupt) ++counters_.corrupt;
      ++counters_.skipped_bytes;
      ++at;
    }
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

}  // namespace vir::uwb
