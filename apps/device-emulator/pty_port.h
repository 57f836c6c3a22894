#pragma once
/// The device's end of a pseudo-terminal, behind a symbolic link whose name stays the same when the
/// device is pulled out and put in again.
#include <cstddef>
#include <string>

namespace vir::emulator {

class PtyPort {
 public:
  /// `link` may be empty. Not plugged in yet.
  explicit PtyPort(std::string link) : link_(std::move(link)) {}
  ~PtyPort();
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;

  /// Throws std::runtime_error if there is no pseudo-terminal to be had, or at `link` is something
  /// that is no symbolic link.
  void plugIn();
  void pullOut();
  bool pluggedIn() const { return master_ >= 0; }
  /// Some program has it open.
  bool hasReader() const;
  /// Bytes taken: fewer than there are when the reader is slow.
  std::size_t write(const std::string& bytes);
  /// What the reader has sent.
  std::string read();
  /// e.g. /dev/pts/7; empty while pulled out.
  const std::string& name() const { return name_; }
  /// The link, or the name where there is none.
  const std::string& path() const { return link_.empty() ? name_ : link_; }

 private:
  std::string link_, name_;
  int master_ = -1;
};

}  // namespace vir::emulator
