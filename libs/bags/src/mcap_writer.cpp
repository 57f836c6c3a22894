#include "vir/bags/mcap_writer.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "vir/bags/bag_reader.h"
#include "vir/bags/message_definition.h"

namespace vir::bags {
namespace {

constexpr char kMagic[] = "\x89MCAP0\r\n";
constexpr std::size_t kChunk = 4u << 20;

enum Op : char {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunkRecord = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

template <typename T>
void add(std::string* out, T v) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &v, sizeof(T));
  out->append(bytes, sizeof(T));
}

void addText(std::string* out, const std::string& text) {
  add(out, static_cast<std::uint32_t>(text.size()));
  *out += text;
}

std::uint64_t ns(TimeNs t) { return static_cast<std::uint64_t>(std::max<TimeNs>(t, 0)); }

std::string record(Op op, const std::string& body) {
  std::string out(1, op);
  add(&out, static_cast<std::uint64_t>(body.size()));
  return out + body;
}

void collect(const std::string& type, const std::map<std::string, std::string>& own,
             std::vector<std::string>* known, std::string* out) {
  if (std::find(known->begin(), known->end(), type) != known->end()) return;
  const auto mine = own.find(type);
  const std::string text =
      mine != own.end() ? mine->second : std::string(standardDefinition(type, Wire::cdr));
  if (text.empty()) throw BagError("the type " + type + " is not known");
  if (!known->empty()) *out += std::string(80, '=') + "\nMSG: " + type + "\n";
  known->push_back(type);
  *out += text;
  const std::string package = type.substr(0, type.find('/'));
  static const char* const basic[] = {"bool",   "byte",    "char",    "int8",   "uint8",
                                      "int16",  "uint16",  "int32",   "uint32", "int64",
                                      "uint64", "float32", "float64", "string", "wstring"};
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::string line = text.substr(from, end - from);
    from = end + 1;
    std::string word = line.substr(0, line.find_first_of(" ["));
    if (word.empty() || word[0] == '#' || line.find('=') != std::string::npos) continue;
    if (std::find(std::begin(basic), std::end(basic), word) != std::end(basic)) continue;
    if (word.find('/') == std::string::npos) word = package + "/" + word;
    collect(word, own, known, out);
  }
}

}  // namespace

CdrWriter& CdrWriter::text(const std::string& v) {
  u32(static_cast<std::uint32_t>(v.size() + 1));
  return raw(v.c_str(), v.size() + 1);
}

CdrWriter& CdrWriter::time(TimeNs t) {
  constexpr TimeNs kSecond = 1'000'000'000;
  const TimeNs seconds = t >= 0 ? t / kSecond : -((kSecond - 1 - t) / kSecond);
  i32(static_cast<std::int32_t>(seconds));
  return u32(static_cast<std::uint32_t>(t - seconds * kSecond));
}

CdrWriter& CdrWriter::raw(const void* data, std::size_t size) {
  const auto* first = static_cast<const std::uint8_t*>(data);
  bytes_.insert(bytes_.end(), first, first + size);
  return *this;
}

std::string longName(const std::string& type) {
  const std::size_t slash = type.find('/');
  return slash == std::string::npos ? type : type.substr(0, slash) + "/msg" + type.substr(slash);
}

std::string fullDefinition(const std::string& type, const std::map<std::string, std::string>& own) {
  std::vector<std::string> known;
  std::string out;
  collect(type, own, &known, &out);
  return out;
}

McapWriter::McapWriter(const std::string& path)
    : path_(path), part_(path + ".part"), file_(part_, std::ios::binary) {
  if (!file_) throw BagError(path + ": cannot be written");
  std::string header;
  addText(&header, "ros2");
  addText(&header, "vir-slam");
  put(std::string(kMagic, 8) + record(kHeader, header));
}

McapWriter::~McapWriter() {
  std::error_code ignored;
  if (!part_.empty()) std::filesystem::remove(part_, ignored);
}

void McapWriter::put(const std::string& bytes) {
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  at_ += bytes.size();
  if (!file_) throw BagError(path_ + ": cannot be written further; is the disk full?");
}

std::string McapWriter::schemaRecord(std::uint16_t id) const {
  const auto& [name, text] = schemas_[id - 1u];
  std::string body;
  add(&body, id);
  addText(&body, longName(name));
  addText(&body, "ros2msg");
  addText(&body, text);
  return record(kSchema, body);
}

std::string McapWriter::channelRecord(const Channel& c) const {
  std::string body;
  add(&body, c.id);
  add(&body, c.schema);
  addText(&body, c.topic);
  addText(&body, "cdr");
  std::string metadata;
  for (const auto& [name, text] : c.metadata) {
    addText(&metadata, name);
    addText(&metadata, text);
  }
  addText(&body, metadata);
  return record(kChannel, body);
}

std::uint16_t McapWriter::channel(const std::string& topic, const std::string& type,
                                  const std::string& definition, const Metadata& metadata) {
  for (const Channel& c : channels_) {
    if (c.topic == topic) return c.id;
  }
  const auto known = std::find_if(schemas_.begin(), schemas_.end(),
                                  [&](const auto& s) { return s.first == type; });
  const auto schema = static_cast<std::uint16_t>(known - schemas_.begin() + 1);
  if (known == schemas_.end()) {
    schemas_.emplace_back(type, definition);
    chunk_ += schemaRecord(schema);
  }
  Channel c;
  c.id = static_cast<std::uint16_t>(channels_.size() + 1);
  c.schema = schema;
  c.topic = topic;
  c.metadata = metadata;
  chunk_ += channelRecord(c);
  channels_.push_back(c);
  return c.id;
}

void McapWriter::write(std::uint16_t channel, TimeNs t, const Bytes& cdr) {
  Channel& c = channels_[channel - 1u];
  std::vector<Entry>& entries = index_[channel];
  std::string body;
  body.reserve(cdr.size() + 22);
  add(&body, channel);
  add(&body, c.sequence++);
  add(&body, ns(t));
  add(&body, ns(t));
  body.append(reinterpret_cast<const char*>(cdr.data()), cdr.size());
  bool empty = true;
  for (const auto& [id, list] : index_) empty = empty && list.empty();
  chunk_first_ = empty ? t : std::min(chunk_first_, t);
  chunk_last_ = empty ? t : std::max(chunk_last_, t);
  first_ = messages_ == 0 ? t : std::min(first_, t);
  last_ = messages_ == 0 ? t : std::max(last_, t);
  entries.push_back({t, chunk_.size()});
  chunk_ += record(kMessage, body);
  ++c.count;
  ++messages_;
  if (chunk_.size() >= kChunk) flushChunk();
}

void McapWriter::flushChunk() {
  if (chunk_.empty()) return;
  ChunkPlace place;
  place.first = chunk_first_;
  place.last = chunk_last_;
  place.at = at_;
  place.size = chunk_.size();
  std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), 1);
  // Pictures that are compressed already do not shrink.
  const bool smaller = ZSTD_isError(size) == 0 && size < chunk_.size() * 95 / 100;
  if (smaller) packed.resize(size);
  place.compression = smaller ? "zstd" : "";
  const std::string& stored = smaller ? packed : chunk_;
  place.stored = stored.size();
  std::string body;
  add(&body, ns(place.first));
  add(&body, ns(place.last));
  add(&body, static_cast<std::uint64_t>(chunk_.size()));
  add(&body, std::uint32_t{0});  // no CRC
  addText(&body, place.compression);
  add(&body, static_cast<std::uint64_t>(stored.size()));
  put(record(kChunkRecord, body + stored));
  place.length = at_ - place.at;
  for (auto& [id, entries] : index_) {
    if (entries.empty()) continue;
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.t < b.t; });
    std::string index;
    add(&index, id);
    add(&index, static_cast<std::uint32_t>(entries.size() * 16));
    for (const Entry& e : entries) {
      add(&index, ns(e.t));
      add(&index, e.offset);
    }
    place.index_at[id] = at_;
    put(record(kMessageIndex, index));
    entries.clear();
  }
  place.index_length = at_ - place.at - place.length;
  chunks_.push_back(std::move(place));
  chunk_.clear();
}

/// Schemas, channels, index of the chunks, statistics; and where each group is.
std::string McapWriter::summary(std::uint64_t at, std::uint64_t* groups_at) const {
  std::string out, offsets;
  const auto group = [&](Op op, std::size_t from) {
    if (out.size() == from) return;
    std::string body(1, op);
    add(&body, at + from);
    add(&body, static_cast<std::uint64_t>(out.size() - from));
    offsets += record(kSummaryOffset, body);
  };
  std::size_t from = out.size();
  for (std::size_t i = 0; i < schemas_.size(); ++i) {
    out += schemaRecord(static_cast<std::uint16_t>(i + 1));
  }
  group(kSchema, from);
  from = out.size();
  for (const Channel& c : channels_) out += channelRecord(c);
  group(kChannel, from);
  from = out.size();
  std::string statistics;
  add(&statistics, messages_);
  add(&statistics, static_cast<std::uint16_t>(schemas_.size()));
  add(&statistics, static_cast<std::uint32_t>(channels_.size()));
  add(&statistics, std::uint32_t{0});  // attachments
  add(&statistics, std::uint32_t{0});  // metadata
  add(&statistics, static_cast<std::uint32_t>(chunks_.size()));
  add(&statistics, ns(first_));
  add(&statistics, ns(last_));
  add(&statistics, static_cast<std::uint32_t>(channels_.size() * 10));
  for (const Channel& c : channels_) {
    add(&statistics, c.id);
    add(&statistics, c.count);
  }
  out += record(kStatistics, statistics);
  group(kStatistics, from);
  from = out.size();
  for (const ChunkPlace& c : chunks_) {
    std::string body;
    add(&body, ns(c.first));
    add(&body, ns(c.last));
    add(&body, c.at);
    add(&body, c.length);
    add(&body, static_cast<std::uint32_t>(c.index_at.size() * 10));
    for (const auto& [id, place] : c.index_at) {
      add(&body, id);
      add(&body, place);
    }
    add(&body, c.index_length);
    addText(&body, c.compression);
    add(&body, c.stored);
    add(&body, c.size);
    out += record(kChunkIndex, body);
  }
  group(kChunkIndex, from);
  *groups_at = at + out.size();
  return out + offsets;
}

void McapWriter::finish() {
  flushChunk();
  put(record(kDataEnd, std::string(4, '\0')));
  const std::uint64_t summary_at = at_;
  std::uint64_t groups_at = 0;
  put(summary(summary_at, &groups_at));
  std::string footer;
  add(&footer, summary_at);
  add(&footer, groups_at);
  add(&footer, std::uint32_t{0});  // no CRC
  put(record(kFooter, footer) + std::string(kMagic, 8));
  file_.close();
  if (!file_) throw BagError(path_ + ": cannot be written further; is the disk full?");
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) throw BagError("cannot rename " + part_ + " to " + path_ + ": " + error.message());
  part_.clear();
}

}  // namespace vir::bags
