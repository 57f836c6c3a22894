#pragma once
/// Writes bags of ROS 1, MCAP and SQLite for tests, in the plainest form of each.
#include <sqlite3.h>

#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir/bags/message_definition.h"

namespace vir::test {

/// Fields of a message one after the other, in the bytes of ROS 1 or CDR.
class WireBytes {
 public:
  explicit WireBytes(bool cdr) : cdr_(cdr) {
    if (cdr) bytes_ = {0, 1, 0, 0};
  }
  template <typename T>
  WireBytes& put(T value) {
    while (cdr_ && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    std::uint8_t raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof raw);
    for (const std::uint8_t b : raw) bytes_.push_back(b);
    return *this;
  }
  template <typename... T>
  WireBytes& doubles(T... values) {
    (put(static_cast<double>(values)), ...);
    return *this;
  }
  WireBytes& zeros(int n) {
    for (int i = 0; i < n; ++i) put(0.0);
    return *this;
  }
  WireBytes& text(const std::string& s) {
    put(static_cast<std::uint32_t>(s.size() + (cdr_ ? 1 : 0)));
    for (const char c : s) bytes_.push_back(static_cast<std::uint8_t>(c));
    if (cdr_) bytes_.push_back(0);
    return *this;
  }
  WireBytes& raw(const std::uint8_t* data, std::size_t size) {
    put(static_cast<std::uint32_t>(size));
    bytes_.insert(bytes_.end(), data, data + size);
    return *this;
  }
  WireBytes& header(TimeNs t, const std::string& frame) {
    if (!cdr_) put(std::uint32_t{0});
    put(static_cast<std::uint32_t>(t / 1'000'000'000));
    put(static_cast<std::uint32_t>(t % 1'000'000'000));
    return text(frame);
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  bool cdr_;
  std::vector<std::uint8_t> bytes_;
};

class BagWriter {
 public:
  virtual ~BagWriter() = default;
  virtual void write(const std::string& topic, const std::string& type,
                     const std::vector<std::uint8_t>& data, TimeNs received) = 0;
  virtual bool cdr() const { return true; }
  WireBytes message() const { return WireBytes(cdr()); }
  /// Text for types that are not standard ones.
  void define(const std::string& type, const std::string& text) { own_[type] = text; }

 protected:
  std::string definition(const std::string& type) const {
    const auto own = own_.find(type);
    if (own != own_.end()) return own->second;
    return std::string(bags::standardDefinition(type, cdr() ? bags::Wire::cdr : bags::Wire::ros1));
  }

 private:
  std::map<std::string, std::string> own_;
};

inline void appendNumber(std::string* out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out->push_back(static_cast<char>(value >> (8 * i)));
}
inline void appendBlock(std::string* out, const std::string& block) {
  appendNumber(out, block.size(), 4);
  *out += block;
}

/// Without chunks and without index.
class Ros1Writer : public BagWriter {
 public:
  explicit Ros1Writer(const std::string& path) : file_(path, std::ios::binary) {
    file_ << "#ROSBAG V2.0\n";
    record({{"op", "\x03"}, {"index_pos", std::string(8, '\0')}}, std::string(4027, ' '));
  }
  bool cdr() const override { return false; }
  void write(const std::string& topic, const std::string& type,
             const std::vector<std::uint8_t>& data, TimeNs received) override {
    std::string id, time;
    const auto [it, fresh] = topics_.emplace(topic, topics_.size());
    appendNumber(&id, it->second, 4);
    if (fresh) {
      std::string about;
      for (const auto& [k, v] : {std::pair<std::string, std::string>{"topic", topic},
                                 {"type", type},
                                 {"md5sum", "*"},
                                 {"message_definition", definition(type)}}) {
        appendBlock(&about, k + "=" + v);
      }
      record({{"op", "\x07"}, {"conn", id}, {"topic", topic}}, about);
    }
    appendNumber(&time, static_cast<std::uint64_t>(received / 1'000'000'000), 4);
    appendNumber(&time, static_cast<std::uint64_t>(received % 1'000'000'000), 4);
    record({{"op", "\x02"}, {"conn", id}, {"time", time}}, {data.begin(), data.end()});
  }

 private:
  void record(const std::vector<std::pair<std::string, std::string>>& fields,
              const std::string& data) {
    std::string header, out;
    for (const auto& [k, v] : fields) appendBlock(&header, k + "=" + v);
    appendBlock(&out, header);
    appendBlock(&out, data);
    file_ << out;
  }

  std::ofstream file_;
  std::map<std::string, std::size_t> topics_;
};

class McapWriter : public BagWriter {
 public:
  explicit McapWriter(const std::string& path) : file_(path, std::ios::binary) {
    file_ << "\x89MCAP0\r\n";
    std::string header;
    appendBlock(&header, "ros2");
    appendBlock(&header, "");
    record(1, header);
  }
  ~McapWriter() override {
    record(15, std::string(4, '\0'));
    record(2, std::string(20, '\0'));
    file_ << "\x89MCAP0\r\n";
  }
  void write(const std::string& topic, const std::string& type,
             const std::vector<std::uint8_t>& data, TimeNs received) override {
    const auto [it, fresh] = topics_.emplace(topic, topics_.size() + 1);
    if (fresh) {
      std::string schema, channel;
      appendNumber(&schema, it->second, 2);
      appendBlock(&schema, type);
      appendBlock(&schema, "ros2msg");
      appendBlock(&schema, definition(type));
      record(3, schema);
      appendNumber(&channel, it->second, 2);
      appendNumber(&channel, it->second, 2);
      appendBlock(&channel, topic);
      appendBlock(&channel, "cdr");
      appendBlock(&channel, "");
      record(4, channel);
    }
    std::string message;
    appendNumber(&message, it->second, 2);
    appendNumber(&message, 0, 4);
    appendNumber(&message, static_cast<std::uint64_t>(received), 8);
    appendNumber(&message, static_cast<std::uint64_t>(received), 8);
    message.append(data.begin(), data.end());
    record(5, message);
  }

 private:
  void record(int op, const std::string& data) {
    std::string out(1, static_cast<char>(op));
    appendNumber(&out, data.size(), 8);
    file_ << out << data;
  }

  std::ofstream file_;
  std::map<std::string, std::size_t> topics_;
};

/// As before Iron: no definitions.
class SqliteWriter : public BagWriter {
 public:
  explicit SqliteWriter(const std::string& path) {
    if (sqlite3_open(path.c_str(), &db_) != SQLITE_OK) throw std::runtime_error(path);
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
        "serialization_format TEXT, offered_qos_profiles TEXT)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
        "data BLOB)");
    run("BEGIN");
  }
  ~SqliteWriter() override {
    run("COMMIT");
    sqlite3_close(db_);
  }
  void write(const std::string& topic, const std::string& type,
             const std::vector<std::uint8_t>& data, TimeNs received) override {
    const auto [it, fresh] = topics_.emplace(topic, topics_.size() + 1);
    const std::string id = std::to_string(it->second);
    if (fresh) {
      const std::string slash =
          type.substr(0, type.find('/')) + "/msg" + type.substr(type.find('/'));
      run("INSERT INTO topics VALUES(" + id + ",'" + topic + "','" + slash + "','cdr','')");
    }
    sqlite3_stmt* s = nullptr;
    const std::string sql = "INSERT INTO messages(topic_id,timestamp,data) VALUES(" + id + "," +
                            std::to_string(received) + ",?)";
    sqlite3_prepare_v2(db_, sql.c_str(), -1, &s, nullptr);
    sqlite3_bind_blob(s, 1, data.data(), static_cast<int>(data.size()), SQLITE_STATIC);
    if (sqlite3_step(s) != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(db_));
    sqlite3_finalize(s);
  }

 private:
  void run(const std::string& sql) {
    if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sql + ": " + sqlite3_errmsg(db_));
    }
  }

  sqlite3* db_ = nullptr;
  std::map<std::string, std::size_t> topics_;
};

// Messages as they are in everyday recordings.

inline void writeImu(BagWriter& bag, const std::string& topic, TimeNs t, TimeNs received,
                     const double (&gyro)[3], const double (&acc)[3]) {
  WireBytes m = bag.message();
  m.header(t, "imu").zeros(4).zeros(9);
  m.doubles(gyro[0], gyro[1], gyro[2]).zeros(9);
  m.doubles(acc[0], acc[1], acc[2]).zeros(9);
  bag.write(topic, "sensor_msgs/Imu", m.bytes(), received);
}

inline void writeImage(BagWriter& bag, const std::string& topic, TimeNs t, TimeNs received,
                       std::uint32_t width, std::uint32_t height, const std::string& encoding,
                       std::uint32_t step, const std::vector<std::uint8_t>& pixels,
                       bool big = false, const std::string& frame = "cam") {
  WireBytes m = bag.message();
  m.header(t, frame).put(height).put(width).text(encoding);
  m.put(static_cast<std::uint8_t>(big)).put(step).raw(pixels.data(), pixels.size());
  bag.write(topic, "sensor_msgs/Image", m.bytes(), received);
}

inline void writeCameraInfo(BagWriter& bag, const std::string& topic, TimeNs t, std::uint32_t width,
                            std::uint32_t height, const std::string& model,
                            const std::vector<double>& D, double fx, double fy, double cx,
                            double cy) {
  WireBytes m = bag.message();
  m.header(t, "cam").put(height).put(width).text(model);
  m.put(static_cast<std::uint32_t>(D.size()));
  for (const double d : D) m.put(d);
  m.doubles(fx, 0, cx, 0, fy, cy, 0, 0, 1);
  m.doubles(1, 0, 0, 0, 1, 0, 0, 0, 1);
  m.doubles(fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0);
  for (int i = 0; i < 6; ++i) m.put(std::uint32_t{0});
  m.put(std::uint8_t{0});
  bag.write(topic, "sensor_msgs/CameraInfo", m.bytes(), t);
}

/// The camera in the IMU: position, quaternion x y z w.
inline void writeStatic(BagWriter& bag, TimeNs t, const double (&p)[3], const double (&q)[4],
                        const std::string& child = "cam") {
  WireBytes m = bag.message();
  m.put(std::uint32_t{1}).header(t, "imu").text(child);
  m.doubles(p[0], p[1], p[2], q[0], q[1], q[2], q[3]);
  bag.write("/tf_static", "tf2_msgs/TFMessage", m.bytes(), t);
}

}  // namespace vir::test
