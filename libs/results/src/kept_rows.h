#pragma once
/// What only the end of a run asks for: beyond a few minutes it is kept in a file without a name,
/// so that the memory of a live run does not grow with its length.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace vir::results {

template <typename Row>
class KeptRows {
  static_assert(std::is_trivially_copyable_v<Row>);

 public:
  /// `folder`: where the file is, once there are more than `in_memory` rows.
  explicit KeptRows(std::string folder, std::size_t in_memory = 4096)
      : folder_(std::move(folder)), in_memory_(in_memory) {
    rows_.reserve(in_memory);
  }
  ~KeptRows() {
    if (file_ != nullptr) std::fclose(file_);
  }
  KeptRows(const KeptRows&) = delete;
  KeptRows& operator=(const KeptRows&) = delete;

  /// Throws std::runtime_error if the disk is full.
  void add(const Row& row) {
    if (rows_.size() == in_memory_) writeOut();
    rows_.push_back(row);
  }
  std::size_t size() const { return written_ + rows_.size(); }

  /// All of them, oldest first. Throws std::runtime_error if they cannot be read.
  std::vector<Row> all() const {
    std::vector<Row> out(written_);
    if (file_ != nullptr) {
      std::rewind(file_);
      if (std::fread(out.data(), sizeof(Row), written_, file_) != written_) fail("read");
    }
    out.insert(out.end(), rows_.begin(), rows_.end());
    return out;
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(std::string("cannot ") + what + " a temporary file in " + folder_ +
                             ": " + std::strerror(errno));
  }
  void open() {
    std::string name = folder_ + "/.kept-XXXXXX";
    const int handle = mkstemp(name.data());
    if (handle < 0) fail("make");
    unlink(name.c_str());
    file_ = fdopen(handle, "w+b");
    if (file_ == nullptr) {
      close(handle);
      fail("make");
    }
  }
  void writeOut() {
    if (file_ == nullptr) open();
    if (std::fwrite(rows_.data(), sizeof(Row), rows_.size(), file_) != rows_.size() ||
        std::fflush(file_) != 0) {
      fail("write");
    }
    written_ += rows_.size();
    rows_.clear();
  }

  std::string folder_;
  std::size_t in_memory_, written_ = 0;
  std::vector<Row> rows_;
  std::FILE* file_ = nullptr;
};

}  // namespace vir::results
