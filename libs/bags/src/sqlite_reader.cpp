/// ROS 2's first storage: a table of topics and one of messages; since Iron also one with the
/// descriptions of types. Messages may be compressed one by one.
#include "sqlite_reader.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <map>

#include "decompress.h"

namespace vir::bags {
namespace {

constexpr std::size_t kMostTopics = 10'000;
constexpr std::uint8_t kZstdMagic[4] = {0x28, 0xB5, 0x2F, 0xFD};

struct CloseDatabase {
  void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
};
struct EndStatement {
  void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
};
using Statement = std::unique_ptr<sqlite3_stmt, EndStatement>;

std::string textOf(sqlite3_stmt* s, int column) {
  const unsigned char* text = sqlite3_column_text(s, column);
  const int size = sqlite3_column_bytes(s, column);
  return text == nullptr
             ? std::string()
             : std::string(reinterpret_cast<const char*>(text), static_cast<std::size_t>(size));
}

/// SQLite reads a page that is not all there as if it ended with zeros. Only whole pages are to be
/// used.
ByteView wholePages(ByteView file) {
  if (file.size < 100) return file;
  const std::size_t two = static_cast<std::size_t>(file.data[16] << 8 | file.data[17]);
  const std::size_t page = two == 1 ? 65536 : two;
  if (page < 512 || (page & (page - 1)) != 0) return file;
  return {file.data, file.size / page * page};
}

/// A file that is not read before it is looked at.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (fd >= 0 && ::fstat(fd, &status) == 0 && status.st_size > 0) {
      size_ = static_cast<std::size_t>(status.st_size);
      void* at = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
      if (at != MAP_FAILED) data_ = static_cast<std::uint8_t*>(at);
    }
    if (fd >= 0) ::close(fd);
  }
  ~MappedFile() {
    if (data_ != nullptr) ::munmap(data_, size_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ByteView view() const { return {data_, data_ == nullptr ? 0 : size_}; }

 private:
  std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Pages that the head announces are missing.
bool isCut(ByteView file) {
  const ByteView whole = wholePages(file);
  if (whole.size != file.size) return true;
  if (file.size < 100) return false;
  const std::uint8_t* h = file.data;
  const auto number = [&](std::size_t at) {
    return static_cast<std::uint64_t>(h[at]) << 24 | static_cast<std::uint64_t>(h[at + 1]) << 16 |
           static_cast<std::uint64_t>(h[at + 2]) << 8 | h[at + 3];
  };
  const std::uint64_t page = h[16] == 0 && h[17] == 1 ? 65536 : h[16] << 8 | h[17];
  // The number of pages holds only where it was written with the last change.
  return number(24) == number(92) && number(28) * page > file.size;
}

class SqliteReader : public BagReader {
 public:
  SqliteReader(const std::string& path, std::string name) : name_(std::move(name)) {
    struct stat status {};
    const bool journal = ::stat((path + "-wal").c_str(), &status) == 0 && status.st_size > 0;
    auto file = std::make_unique<MappedFile>(path);
    if (!journal && isCut(file->view())) {
      mapped_ = std::move(file);
      openBytes(mapped_->view());
    } else {
      open(path, journal);
    }
    begin();
  }
  SqliteReader(ByteView bytes, std::string name) : name_(std::move(name)) {
    openBytes(bytes);
    begin();
  }

  bool next(BagMessage* message) override {
    while (messages_) {
      const int code = sqlite3_step(messages_.get());
      if (code != SQLITE_ROW) {
        if (code != SQLITE_DONE) {
          report(name_ + ": cannot be read further after message " + std::to_string(row_) + " (" +
                 sqlite3_errmsg(db_.get()) + "): the file is cut off or damaged; what comes " +
                 "before is used");
        }
        messages_.reset();
        break;
      }
      // Pages of a damaged file may lead in circles.
      const std::int64_t row = sqlite3_column_int64(messages_.get(), 0);
      if (row_ != 0 && row <= row_) {
        report(name_ + ": is damaged after message " + std::to_string(row_) +
               "; what comes before is used");
        messages_.reset();
        break;
      }
      row_ = row;
      if (take(message)) return true;
    }
    return false;
  }
  double progress() const override {
    if (!messages_) return 1;
    return std::min(1.0, static_cast<double>(row_) / static_cast<double>(last_));
  }

 private:
  void openBytes(ByteView bytes) {
    sqlite3* db = nullptr;
    sqlite3_open_v2(":memory:", &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    db_.reset(db);
    if (isCut(bytes)) {
      report(name_ + ": is cut off: it is shorter than its head says; what is there is used");
    }
    bytes = wholePages(bytes);
    // Not written to, in spite of the type.
    const int code = sqlite3_deserialize(
        db, "main", const_cast<std::uint8_t*>(bytes.data), static_cast<sqlite3_int64>(bytes.size),
        static_cast<sqlite3_int64>(bytes.size), SQLITE_DESERIALIZE_READONLY);
    if (code != SQLITE_OK) throw BagError(name_ + ": cannot be read: " + sqlite3_errstr(code));
  }

  void begin() {
    // The file may come from anywhere. `writable_schema` lets a file be read that is shorter than
    // its head says (cut off); nothing is written.
    sqlite3_exec(db_.get(),
                 "PRAGMA writable_schema=ON; PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON; "
                 "PRAGMA mmap_size=0",
                 nullptr, nullptr, nullptr);
    sqlite3_limit(db_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(kMostBlock));
    readDefinitions();
    readTopics();
    last_ = std::max<std::int64_t>(1, number("SELECT max(rowid) FROM messages"));
    messages_ = prepare("SELECT rowid, topic_id, timestamp, data FROM messages ORDER BY rowid");
    if (!messages_) {
      throw BagError(name_ + ": is no bag of ROS 2: no table of messages can be read in it (" +
                     sqlite3_errmsg(db_.get()) + ")");
    }
  }

  /// Without a journal beside it nobody writes to the file, and read-only folders will do too.
  void open(const std::string& path, bool journal) {
    std::string uri = "file:";
    for (const char c : path) {
      if (c == '?' || c == '#' || c == '%') {
        const char hex[] = "0123456789ABCDEF";
        uri += {'%', hex[(c >> 4) & 15], hex[c & 15]};
      } else {
        uri += c;
      }
    }
    uri += journal ? "?mode=ro" : "?mode=ro&immutable=1";
    sqlite3* db = nullptr;
    const int code =
        sqlite3_open_v2(uri.c_str(), &db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    db_.reset(db);
    if (code != SQLITE_OK) throw BagError(name_ + ": cannot be opened: " + sqlite3_errstr(code));
  }

  Statement prepare(const char* sql) {
    sqlite3_stmt* s = nullptr;
    if (sqlite3_prepare_v2(db_.get(), sql, -1, &s, nullptr) != SQLITE_OK) return nullptr;
    return Statement(s);
  }

  std::int64_t number(const char* sql) {
    const Statement s = prepare(sql);
    return s && sqlite3_step(s.get()) == SQLITE_ROW ? sqlite3_column_int64(s.get(), 0) : 0;
  }

  /// Files from before Iron have none.
  void readDefinitions() {
    const Statement s =
        prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    while (s && sqlite3_step(s.get()) == SQLITE_ROW && definitions_.size() < kMostTopics) {
      if (textOf(s.get(), 1) != "ros2msg") continue;
      definitions_[shortTypeName(textOf(s.get(), 0))] =
          std::make_shared<const std::string>(textOf(s.get(), 2));
    }
  }

  void readTopics() {
    const Statement s = prepare("SELECT id, name, type, serialization_format FROM topics");
    int code = SQLITE_ERROR;
    while (s && (code = sqlite3_step(s.get())) == SQLITE_ROW) {
      Channel c;
      c.topic = textOf(s.get(), 1);
      c.type = shortTypeName(textOf(s.get(), 2));
      c.encoding = textOf(s.get(), 3);
      c.wire = c.encoding == "cdr" ? Wire::cdr : Wire::unknown;
      const auto definition = definitions_.find(c.type);
      if (definition != definitions_.end()) c.definition = definition->second;
      channels_.emplace(sqlite3_column_int64(s.get(), 0), std::move(c));
      if (channels_.size() >= kMostTopics) {
        code = SQLITE_DONE;
        break;
      }
    }
    // Of a table that is damaged further on some topics may be there.
    if (code != SQLITE_DONE && channels_.empty()) {
      throw BagError(name_ + ": is no bag of ROS 2, or is damaged at its beginning: its table of " +
                     "topics cannot be read (" + sqlite3_errmsg(db_.get()) + ")");
    }
  }

  bool take(BagMessage* message) {
    sqlite3_stmt* s = messages_.get();
    const auto channel = channels_.find(sqlite3_column_int64(s, 1));
    if (channel == channels_.end()) return false;
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(s, 3));
    const int size = sqlite3_column_bytes(s, 3);
    message->channel = &channel->second;
    message->received = receivedAt(sqlite3_column_int64(s, 2));
    message->data = {data, data == nullptr ? 0 : static_cast<std::size_t>(size)};
    // CDR begins with 0, so that this cannot be one.
    if (message->data.size >= 4 && std::memcmp(data, kZstdMagic, 4) == 0) {
      const std::string why = decompress("zstd", message->data, 0, &unpacked_);
      if (!why.empty()) {
        report(name_ + ": message " + std::to_string(row_) + " is left out: " + why);
        return false;
      }
      message->data = {unpacked_.data(), unpacked_.size()};
    }
    return true;
  }

  std::string name_;
  std::unique_ptr<MappedFile> mapped_;
  std::unique_ptr<sqlite3, CloseDatabase> db_;
  Statement messages_;
  std::map<std::string, std::shared_ptr<const std::string>> definitions_;
  std::map<std::int64_t, Channel> channels_;
  Bytes unpacked_;
  std::int64_t row_ = 0, last_ = 1;
};

}  // namespace

std::unique_ptr<BagReader> openSqlite(ByteView bytes, const std::string& name) {
  return std::make_unique<SqliteReader>(bytes, name);
}

std::unique_ptr<BagReader> openSqlite(const std::string& path, const std::string& name) {
  return std::make_unique<SqliteReader>(path, name);
}

}  // namespace vir::bags
