/// MCAP: records with one byte that says what they are and eight that say how long; chunks hold
/// such records compressed. The index at the end is not needed.
#include "mcap_reader.h"

#include <zlib.h>

#include <map>

#include "decompress.h"

namespace vir::bags {
namespace {

constexpr std::uint8_t kMagic[8] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum Op { kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15 };

struct Schema {
  std::string name;
  std::shared_ptr<const std::string> text;  ///< none if it is in another language than ROS's
};

Wire wireOf(const std::string& encoding) {
  if (encoding == "ros1") return Wire::ros1;
  return encoding == "cdr" ? Wire::cdr : Wire::unknown;
}

class McapReader : public BagReader {
 public:
  explicit McapReader(InputFile file) : file_(std::move(file)) {
    std::uint8_t magic[8];
    if (!file_.read(magic, 8) || std::memcmp(magic, kMagic, 8) != 0) {
      throw BagError(file_.name() + ": is no MCAP file (it does not begin like one)");
    }
  }

  bool next(BagMessage* message) override {
    while (!done_) {
      if (in_chunk_) {
        if (nextInChunk(message)) return true;
        in_chunk_ = false;
      } else if (nextInFile(message)) {
        return true;
      }
    }
    return false;
  }
  double progress() const override { return done_ ? 1 : file_.progress(); }

 private:
  bool stop(const std::string& why) {
    report(file_.where() + ": " + why + "; what comes before is used");
    done_ = true;
    return false;
  }

  bool nextInFile(BagMessage* message) {
    std::uint8_t head[9];
    if (cut_) {
      done_ = true;
      return false;
    }
    if (!file_.read(head, 9)) return stop("the file is cut off (it has no end record)");
    const int op = head[0];
    const std::uint64_t size = littleEndian<std::uint64_t>(head + 1);
    if (op == kDataEnd || op == kFooter) {
      done_ = true;
      return false;
    }
    cut_ = size > file_.left();
    if (cut_ && op != kChunk) return stop("the file is cut off, or damaged here");
    if (op != kSchema && op != kChannel && op != kMessage && op != kChunk) {
      file_.skip(size);
      return false;
    }
    if (!cut_ && size > kMostBlock) {
      return stop("a record of more than 1 GB, the file is damaged here");
    }
    if (cut_) report(file_.where() + ": the file is cut off within a chunk");
    file_.readUpTo(std::min<std::uint64_t>(size, kMostBlock), &data_);
    const ByteView data{data_.data(), data_.size()};
    if (op != kChunk) return takeRecord(op, data, message);
    openChunk(data);
    return false;
  }

  void openChunk(ByteView data) {
    ByteCursor cursor(data);
    std::uint64_t from = 0, to = 0, unpacked = 0, size = 0;
    std::uint32_t crc = 0;
    ByteView name, records;
    if (!cursor.number(&from) || !cursor.number(&to) || !cursor.number(&unpacked) ||
        !cursor.number(&crc) || !cursor.block(&name) || !cursor.number(&size)) {
      return;
    }
    const bool cut = size > cursor.left();
    cursor.take(std::min<std::uint64_t>(size, cursor.left()), &records);
    const std::string compression(name.text());
    if (!knownCompression(compression) || unpacked > kMostBlock) {
      report(file_.where() + ": a chunk compressed by '" + compression +
             "', or of more than 1 GB, is left out (none, lz4, zstd are known)");
      return;
    }
    std::string why;
    if (compression.empty() || compression == "none") {
      rest_ = ByteCursor(records);
    } else {
      why = decompress(compression, records, unpacked, &chunk_);
      records = {chunk_.data(), chunk_.size()};
      rest_ = ByteCursor(records);
    }
    if (!cut && !why.empty()) {
      report(file_.where() + ": a chunk is damaged (" + why + "); what could be unpacked is used");
    } else if (!cut && crc != 0 && crc != ::crc32_z(0, records.data, records.size)) {
      report(file_.where() + ": a chunk is damaged (its checksum differs); its messages are left " +
             "out");
      takeDescriptions();
      return;
    }
    in_chunk_ = true;
  }

  /// Without what a damaged chunk says of topics, later ones would be worth nothing.
  void takeDescriptions() {
    std::uint8_t op = 0;
    std::uint64_t size = 0;
    ByteView data;
    while (rest_.number(&op) && rest_.number(&size) && rest_.take(size, &data)) {
      if (op != kMessage) takeRecord(op, data, nullptr);
    }
  }

  bool nextInChunk(BagMessage* message) {
    while (rest_.left() > 0) {
      std::uint8_t op = 0;
      std::uint64_t size = 0;
      ByteView data;
      if (!rest_.number(&op) || !rest_.number(&size) || !rest_.take(size, &data)) return false;
      if (takeRecord(op, data, message)) return true;
    }
    return false;
  }

  bool takeRecord(int op, ByteView data, BagMessage* message) {
    if (op == kSchema) addSchema(data);
    if (op == kChannel) addChannel(data);
    if (op != kMessage) return false;
    ByteCursor cursor(data);
    std::uint16_t id = 0;
    std::uint32_t sequence = 0;
    std::uint64_t logged = 0, published = 0;
    if (!cursor.number(&id) || !cursor.number(&sequence) || !cursor.number(&logged) ||
        !cursor.number(&published)) {
      return false;
    }
    const auto channel = channels_.find(id);
    if (channel == channels_.end()) {
      if (!unknown_said_) {
        report(file_.where() + ": messages of a channel (" + std::to_string(id) +
               ") that was never described are left out");
      }
      unknown_said_ = true;
      return false;
    }
    message->channel = &channel->second;
    message->received = receivedAt(static_cast<TimeNs>(logged));
    cursor.take(cursor.left(), &message->data);
    return true;
  }

  void addSchema(ByteView data) {
    ByteCursor cursor(data);
    std::uint16_t id = 0;
    ByteView name, encoding, text;
    if (!cursor.number(&id) || !cursor.block(&name) || !cursor.block(&encoding) ||
        !cursor.block(&text) || schemas_.count(id) > 0) {
      return;
    }
    Schema& schema = schemas_[id];
    schema.name = shortTypeName(std::string(name.text()));
    // Standard types that are described in IDL are known without it.
    if (encoding.text() == "ros1msg" || encoding.text() == "ros2msg") {
      schema.text = std::make_shared<const std::string>(text.text());
    }
  }

  void addChannel(ByteView data) {
    ByteCursor cursor(data);
    std::uint16_t id = 0, schema_id = 0;
    ByteView topic, encoding, metadata;
    if (!cursor.number(&id) || !cursor.number(&schema_id) || !cursor.block(&topic) ||
        !cursor.block(&encoding) || channels_.count(id) > 0) {
      return;
    }
    Channel c;
    if (cursor.block(&metadata)) {
      ByteCursor texts(metadata);
      ByteView name, text;
      while (texts.block(&name) && texts.block(&text)) {
        c.metadata.emplace(name.text(), text.text());
      }
    }
    c.topic = topic.text();
    c.encoding = encoding.text();
    c.wire = wireOf(c.encoding);
    const auto schema = schemas_.find(schema_id);
    if (schema != schemas_.end()) {
      c.type = schema->second.name;
      c.definition = schema->second.text;
    }
    channels_.emplace(id, std::move(c));
  }

  InputFile file_;
  Bytes data_, chunk_;
  ByteCursor rest_{ByteView{}};
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  bool in_chunk_ = false, cut_ = false, done_ = false, unknown_said_ = false;
};

}  // namespace

std::unique_ptr<BagReader> openMcap(InputFile file) {
  return std::make_unique<McapReader>(std::move(file));
}

}  // namespace vir::bags
