#pragma once
/// Writes MCAP files with messages of ROS 2, for programs that show recordings.
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "vir/bags/bytes.h"
#include "vir/bags/message_sink.h"
#include "vir/core/time.h"

namespace vir::bags {

/// A message of ROS 2 in the bytes of CDR, little endian, field by field.
class CdrWriter {
 public:
  CdrWriter() : bytes_{0, 1, 0, 0} {}
  CdrWriter& boolean(bool v) { return put(static_cast<std::uint8_t>(v ? 1 : 0)); }
  CdrWriter& u8(std::uint8_t v) { return put(v); }
  CdrWriter& i32(std::int32_t v) { return put(v); }
  CdrWriter& u32(std::uint32_t v) { return put(v); }
  CdrWriter& i64(std::int64_t v) { return put(v); }
  CdrWriter& f32(float v) { return put(v); }
  CdrWriter& f64(double v) { return put(v); }
  CdrWriter& text(const std::string& v);
  CdrWriter& time(TimeNs t);
  /// Bytes as they are, without a count.
  CdrWriter& raw(const void* data, std::size_t size);
  const Bytes& bytes() const { return bytes_; }

 private:
  template <typename T>
  CdrWriter& put(T v) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    return raw(&v, sizeof v);
  }
  Bytes bytes_;
};

/// package/Type as ROS 2 has it: package/msg/Type.
std::string longName(const std::string& type);

/// The text of a standard type of ROS 2 with all types in it, as recordings carry it. `own`: types
/// that are no standard ones, with their text. Throws BagError for a type that is not known.
std::string fullDefinition(const std::string& type, const std::map<std::string, std::string>& own);

/// In chunks with an index, so that readers can jump to a time; `PATH.part` until finish(), and
/// gone without it. Throws BagError when the file cannot be written.
class McapWriter : public MessageSink {
 public:
  explicit McapWriter(const std::string& path);
  ~McapWriter() override;
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;
  std::uint16_t channel(const std::string& topic, const std::string& type,
                        const std::string& definition, const Metadata& metadata = {}) override;
  void write(std::uint16_t channel, TimeNs t, const Bytes& cdr) override;
  /// Index and end of the file, and its name.
  void finish();

 private:
  struct Channel {
    std::uint16_t id = 0, schema = 0;
    std::string topic;
    Metadata metadata;
    std::uint64_t count = 0;
    std::uint32_t sequence = 0;
  };
  struct Entry {
    TimeNs t = 0;
    std::uint64_t offset = 0;
  };
  struct ChunkPlace {
    TimeNs first = 0, last = 0;
    std::uint64_t at = 0, length = 0, index_length = 0, size = 0, stored = 0;
    std::map<std::uint16_t, std::uint64_t> index_at;
    std::string compression;
  };

  void put(const std::string& bytes);
  void flushChunk();
  std::string schemaRecord(std::uint16_t id) const;
  std::string channelRecord(const Channel& c) const;
  std::string summary(std::uint64_t at, std::uint64_t* groups_at) const;

  std::string path_, part_;
  std::ofstream file_;
  std::uint64_t at_ = 0;
  std::vector<Channel> channels_;
  std::vector<std::pair<std::string, std::string>> schemas_;  // name, text
  std::string chunk_;
  std::map<std::uint16_t, std::vector<Entry>> index_;
  TimeNs chunk_first_ = 0, chunk_last_ = 0, first_ = 0, last_ = 0;
  std::uint64_t messages_ = 0;
  std::vector<ChunkPlace> chunks_;
};

}  // namespace vir::bags
