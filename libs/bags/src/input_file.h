#pragma once
#include <cstdio>
#include <memory>
#include <string>

#include "vir/bags/bytes.h"

namespace vir::bags {

/// A file from front to back.
class InputFile {
 public:
  /// Throws BagError if it cannot be opened.
  explicit InputFile(const std::string& path);
  /// Bytes in memory, for tests; they must outlive this.
  InputFile(ByteView bytes, std::string name);

  /// False (and nothing useful in `out`) if fewer bytes are left or reading fails.
  bool read(void* out, std::size_t size);
  /// As many as there are, at most `size`; resized to what came.
  void readUpTo(std::uint64_t size, Bytes* out);
  /// To the end at most.
  void skip(std::uint64_t size);

  std::uint64_t left() const { return size_ - position_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t size() const { return size_; }
  double progress() const {
    return size_ == 0 ? 1.0 : static_cast<double>(position_) / static_cast<double>(size_);
  }
  const std::string& name() const { return name_; }
  /// `name: at byte n`.
  std::string where() const;

 private:
  struct Close {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  ByteView memory_;
  std::string name_;
  std::uint64_t size_ = 0, position_ = 0;
};

}  // namespace vir::bags
