/// A ROS 1 bag is a sequence of records (header fields, data); chunks hold such records compressed.
/// Connections come before their first message in every chunk, so the index at the end is not
/// needed.
#include "ros1_reader.h"

#include <map>
#include <optional>

#include "decompress.h"

namespace vir::bags {
namespace {

constexpr const char* kMagic = "#ROSBAG V2.0\n";

enum Op { kMessage = 2, kBagHeader = 3, kIndex = 4, kChunk = 5, kChunkInfo = 6, kConnection = 7 };

/// `name=value` pairs, each with its length before it.
class Fields {
 public:
  /// False if this is no header.
  bool parse(ByteView header) {
    fields_.clear();
    ByteCursor cursor(header);
    while (cursor.left() > 0) {
      ByteView field;
      if (!cursor.block(&field)) return false;
      const std::string_view text = field.text();
      const std::size_t equals = text.find('=');
      if (equals == std::string_view::npos || fields_.size() >= kMost) return false;
      fields_.emplace_back(text.substr(0, equals),
                           ByteView{field.data + equals + 1, field.size - equals - 1});
    }
    return true;
  }
  std::optional<ByteView> find(std::string_view name) const {
    for (const auto& [key, value] : fields_) {
      if (key == name) return value;
    }
    return std::nullopt;
  }
  template <typename T>
  std::optional<T> number(std::string_view name) const {
    const auto value = find(name);
    if (!value || value->size != sizeof(T)) return std::nullopt;
    return littleEndian<T>(value->data);
  }
  std::string text(std::string_view name) const {
    const auto value = find(name);
    return value ? std::string(value->text()) : std::string();
  }

 private:
  static constexpr std::size_t kMost = 100;
  std::vector<std::pair<std::string_view, ByteView>> fields_;
};

class Ros1Reader : public BagReader {
 public:
  explicit Ros1Reader(InputFile file) : file_(std::move(file)) {
    Bytes magic;
    file_.readUpTo(std::strlen(kMagic), &magic);
    if (ByteView{magic.data(), magic.size()}.text() != kMagic) {
      throw BagError(file_.name() +
                     ": is no ROS bag of version 2.0; older ones are brought to it by "
                     "`rosbag fix`");
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
  /// Ends the reading.
  bool stop(const std::string& why) {
    report(file_.where() + ": " + why + "; what comes before is used");
    done_ = true;
    return false;
  }

  /// A record of the file. True if it is a message (of a bag that was written without chunks, or
  /// in a chunk that is not compressed: its records are read as if they were the file's own).
  bool nextInFile(BagMessage* message) {
    if (file_.left() == 0) {
      done_ = true;
      return false;
    }
    std::uint8_t length[4];
    if (!file_.read(length, 4)) return stop("the file is cut off");
    const std::uint32_t header_size = littleEndian<std::uint32_t>(length);
    if (header_size > file_.left()) return stop("the file is cut off, or damaged here");
    file_.readUpTo(header_size, &header_);
    if (!fields_.parse({header_.data(), header_.size()})) return stop("the file is damaged here");
    if (!file_.read(length, 4)) return stop("the file is cut off");
    const std::uint32_t size = littleEndian<std::uint32_t>(length);
    const int op = fields_.number<std::uint8_t>("op").value_or(0);
    if (op == kChunk) return openChunk(size);
    if (op != kMessage && op != kConnection) {
      if (op == kBagHeader && !fields_.text("encryptor").empty()) {
        throw BagError(file_.name() + ": is encrypted; decrypt it first (`rosbag encrypt`)");
      }
      // Written last, into a place that is kept for it.
      if (op == kBagHeader && fields_.number<std::uint64_t>("index_pos").value_or(1) == 0) {
        note(file_.name() +
             ": has no index: whoever recorded it was ended before closing it, so that its last "
             "seconds may be missing; what is there is read (`rosbag reindex` is not needed)");
      }
      if (size > file_.left()) return stop("the file is cut off");
      file_.skip(size);
      return false;
    }
    if (size > file_.left()) return stop("the file is cut off within a message");
    file_.readUpTo(size, &data_);
    return takeRecord(op, {data_.data(), data_.size()}, message);
  }

  bool openChunk(std::uint32_t size) {
    const std::string compression = fields_.text("compression");
    if (compression == "none") return false;  // go on inside
    if (!knownCompression(compression)) {
      report(file_.where() + ": a chunk compressed by '" + compression +
             "', which is not known (none, bz2, lz4 are), is left out");
      file_.skip(size);
      return false;
    }
    const std::uint32_t unpacked = fields_.number<std::uint32_t>("size").value_or(0);
    const bool cut = size > file_.left();
    const std::string where = file_.where();
    if (size > kMostBlock || unpacked > kMostBlock) {
      return stop("a chunk of more than 1 GB, the file is damaged here");
    }
    file_.readUpTo(size, &packed_);
    const std::string why =
        decompress(compression, {packed_.data(), packed_.size()}, unpacked, &chunk_);
    if (cut) {
      report(where + ": the file is cut off within a chunk; what comes before is used");
    } else if (!why.empty()) {
      report(where + ": a chunk is damaged (" + why + "); what could be unpacked of it is used");
    }
    rest_ = ByteCursor({chunk_.data(), chunk_.size()});
    in_chunk_ = true;
    return false;
  }

  /// False at the end of the chunk.
  bool nextInChunk(BagMessage* message) {
    while (rest_.left() > 0) {
      ByteView header, data;
      if (!rest_.block(&header) || !rest_.block(&data) || !fields_.parse(header)) return false;
      const int op = fields_.number<std::uint8_t>("op").value_or(0);
      if (takeRecord(op, data, message)) return true;
    }
    return false;
  }

  bool takeRecord(int op, ByteView data, BagMessage* message) {
    const auto id = fields_.number<std::uint32_t>("conn");
    if (op == kConnection && id) addConnection(*id, data);
    const auto time = fields_.find("time");
    if (op != kMessage || !id || !time || time->size != 8) return false;
    const auto channel = channels_.find(*id);
    if (channel == channels_.end()) {
      if (!unknown_said_) {
        report(file_.where() + ": messages of a connection (" + std::to_string(*id) +
               ") that was never described are left out");
      }
      unknown_said_ = true;
      return false;
    }
    message->channel = &channel->second;
    message->received = littleEndian<std::uint32_t>(time->data) * TimeNs{1'000'000'000} +
                        littleEndian<std::uint32_t>(time->data + 4);
    message->data = data;
    return true;
  }

  void addConnection(std::uint32_t id, ByteView data) {
    if (channels_.count(id) > 0 || channels_.size() >= kMostChannels) return;
    const std::string topic = fields_.text("topic");
    Fields about;
    if (!about.parse(data)) return;
    Channel c;
    c.topic = topic;
    c.type = shortTypeName(about.text("type"));
    c.definition = std::make_shared<const std::string>(about.text("message_definition"));
    c.wire = Wire::ros1;
    c.encoding = "ros1";
    channels_.emplace(id, std::move(c));
  }

  static constexpr std::size_t kMostChannels = 100'000;

  InputFile file_;
  Fields fields_;
  Bytes header_, data_, packed_, chunk_;
  ByteCursor rest_{ByteView{}};
  std::map<std::uint32_t, Channel> channels_;
  bool in_chunk_ = false, done_ = false, unknown_said_ = false;
};

}  // namespace

std::unique_ptr<BagReader> openRos1(InputFile file) {
  return std::make_unique<Ros1Reader>(std::move(file));
}

}  // namespace vir::bags
