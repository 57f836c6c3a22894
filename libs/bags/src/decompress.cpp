#include "decompress.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "input_file.h"

namespace vir::bags {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 18;
// A block of this size may be anything (black images pack a thousandfold); beyond it what packs
// more than images ever do was made to fill the memory.
constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{64} << 20;
constexpr std::uint64_t kGrowth = 200;

/// What may come out of `packed` bytes.
std::uint64_t mostOf(std::size_t packed) {
  return std::min(kMostBlock, std::max(kAlwaysAllowed, kGrowth * packed));
}

/// What one call of a decompressor did.
struct Step {
  std::size_t taken = 0, given = 0;
  bool end = false;
  std::string error;
};
using Stepper = std::function<Step(ByteView in, std::uint8_t* out, std::size_t room)>;

/// Calls `step` until its end, with room made as it is used. There is room for one byte more than
/// `most`, so that an end mark behind the last byte is still taken.
std::string pump(ByteView in, std::uint64_t most, Bytes* out, const Stepper& step) {
  std::size_t filled = 0;
  std::string why;
  for (;;) {
    if (filled == out->size()) {
      const std::size_t more = std::max(kStep, filled / 2);
      out->resize(static_cast<std::size_t>(std::min<std::uint64_t>(most + 1, filled + more)));
    }
    const Step s = step(in, out->data() + filled, out->size() - filled);
    in.data += s.taken;
    in.size -= s.taken;
    filled += s.given;
    if (filled > most) {
      filled = static_cast<std::size_t>(most);
      why = "more came out than there should be";
      break;
    }
    if (s.end || !s.error.empty()) {
      why = s.error;
      break;
    }
    if (s.taken == 0 && s.given == 0) {
      why = "the compressed data ends early";
      break;
    }
  }
  out->resize(filled);
  return why;
}

std::string unzipBz2(ByteView in, std::uint64_t most, Bytes* out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw BagError("bzip2: no memory");
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> owner(&stream, BZ2_bzDecompressEnd);
  return pump(in, most, out, [&](ByteView v, std::uint8_t* to, std::size_t room) {
    // bzlib takes a pointer to what it does not change.
    stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(v.data));
    stream.avail_in = static_cast<unsigned>(std::min<std::size_t>(v.size, kMostBlock));
    stream.next_out = reinterpret_cast<char*>(to);
    stream.avail_out = static_cast<unsigned>(room);
    const unsigned offered = stream.avail_in;
    const int code = BZ2_bzDecompress(&stream);
    Step s{offered - stream.avail_in, room - stream.avail_out, code == BZ_STREAM_END, {}};
    if (code < 0) s.error = "its bzip2 data is damaged (" + std::to_string(code) + ")";
    return s;
  });
}

std::string unzipLz4(ByteView in, std::uint64_t most, Bytes* out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) {
    throw BagError("lz4: no memory");
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> owner(
      context, LZ4F_freeDecompressionContext);
  return pump(in, most, out, [&](ByteView v, std::uint8_t* to, std::size_t room) {
    std::size_t taken = v.size, given = room;
    const std::size_t code = LZ4F_decompress(context, to, &given, v.data, &taken, nullptr);
    if (LZ4F_isError(code)) {
      return Step{0, 0, false, std::string("its lz4 data is damaged: ") + LZ4F_getErrorName(code)};
    }
    return Step{taken, given, code == 0, {}};
  });
}

struct FreeZstd {
  void operator()(ZSTD_DCtx* c) const { ZSTD_freeDCtx(c); }
};
using ZstdContext = std::unique_ptr<ZSTD_DCtx, FreeZstd>;

ZstdContext zstdContext() {
  ZstdContext context(ZSTD_createDCtx());
  if (!context) throw BagError("zstd: no memory");
  // A window of 128 MB is what the zstd program takes without being asked for more.
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, 27);
  return context;
}

Step zstdStep(ZSTD_DCtx* context, ByteView v, std::uint8_t* to, std::size_t room) {
  ZSTD_inBuffer in{v.data, v.size, 0};
  ZSTD_outBuffer out{to, room, 0};
  const std::size_t code = ZSTD_decompressStream(context, &out, &in);
  if (ZSTD_isError(code)) {
    return {0, 0, false, std::string("its zstd data is damaged: ") + ZSTD_getErrorName(code)};
  }
  return {in.pos, out.pos, code == 0, {}};
}

}  // namespace

bool knownCompression(const std::string& name) {
  return name.empty() || name == "none" || name == "bz2" || name == "lz4" || name == "zstd";
}

std::string decompress(const std::string& name, ByteView in, std::uint64_t size, Bytes* out) {
  const std::uint64_t bound = mostOf(in.size);
  const std::uint64_t most = size == 0 ? bound : std::min(size, bound);
  // The buffer is kept from block to block: what it has grown to is no news.
  out->resize(static_cast<std::size_t>(std::min<std::uint64_t>(out->capacity(), most + 1)));
  std::string why;
  if (name == "bz2") {
    why = unzipBz2(in, most, out);
  } else if (name == "lz4") {
    why = unzipLz4(in, most, out);
  } else if (name == "zstd") {
    const ZstdContext context = zstdContext();
    why = pump(in, most, out, [&](ByteView v, std::uint8_t* to, std::size_t room) {
      return zstdStep(context.get(), v, to, room);
    });
  } else {
    const std::size_t n = static_cast<std::size_t>(std::min<std::uint64_t>(in.size, most));
    out->assign(in.data, in.data + n);
  }
  if (!why.empty() && out->size() == bound) {
    why = "it unpacks to more than 64 MB and more than " + std::to_string(kGrowth) +
          " times its size in the file";
  }
  if (why.empty() && size != 0 && out->size() != size) {
    why =
        "it holds " + std::to_string(out->size()) + " bytes where it says " + std::to_string(size);
  }
  return why;
}

std::string decompressFile(const std::string& from, int to_fd) {
  InputFile file(from);
  const ZstdContext context = zstdContext();
  Bytes in, out(kStep);
  const std::uint64_t most = std::max(kMostBlock, kGrowth * file.size());
  std::uint64_t written = 0;
  std::string why = "it ends early";
  while (file.left() > 0) {
    file.readUpTo(kStep, &in);
    if (in.empty()) break;
    ByteView rest{in.data(), in.size()};
    for (bool more = true; more;) {
      const Step s = zstdStep(context.get(), rest, out.data(), out.size());
      if (!s.error.empty()) return s.error;
      written += s.given;
      if (written > most) return "it unpacks to more than 1 GB and more than 200 times its size";
      for (std::size_t done = 0; done < s.given;) {
        const ssize_t n = ::write(to_fd, out.data() + done, s.given - done);
        if (n <= 0) throw BagError(from + ": no room to unpack it; set TMPDIR to a larger disk");
        done += static_cast<std::size_t>(n);
      }
      rest.data += s.taken;
      rest.size -= s.taken;
      why = s.end ? "" : "it ends early";
      more = rest.size > 0 || s.given == out.size();
      if (s.taken == 0 && s.given == 0) more = false;
    }
  }
  return why;
}

}  // namespace vir::bags
