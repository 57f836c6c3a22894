#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "vir/core/text_file.h"
#include "vir/mission/mission_map.h"

namespace vir::mission {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const std::string& what, const std::string& file, int error) {
  throw std::runtime_error(what + " " + file + ": " + std::strerror(error));
}

/// All of it, and on the disk: a rename before would leave an empty file after a loss of power.
void writeAll(const std::string& file, const std::string& bytes) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) fail("cannot create", file, errno);
  std::size_t done = 0;
  int error = 0;
  while (done < bytes.size() && error == 0) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n > 0) done += static_cast<std::size_t>(n);
    if (n < 0 && errno != EINTR) error = errno;
  }
  if (error == 0 && ::fsync(fd) != 0) error = errno;
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error == 0) return;
  std::error_code ignored;
  fs::remove(file, ignored);
  fail("cannot write", file, error);
}

}  // namespace

void saveMap(const MissionMap& map, const std::string& file) {
  if (map.keyframes.empty()) {
    throw std::runtime_error("the map " + file + " is not written: it would hold no place");
  }
  const std::string part = file + ".part";
  writeAll(part, encode(map));
  std::error_code error;
  fs::rename(part, file, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(part, ignored);
  throw std::runtime_error("cannot rename " + part + " to " + file + ": " + error.message());
}

MissionMap loadMap(const std::string& file) {
  const std::string wrong = notAFile(file);
  if (!wrong.empty()) throw std::runtime_error("the map " + file + " cannot be read: " + wrong);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("there is no map " + file);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) throw std::runtime_error("the map " + file + " cannot be read");
  try {
    MissionMap map = decode(bytes);
    if (map.keyframes.empty()) {
      throw std::runtime_error("it holds no place that a run could be found by; make it again");
    }
    return map;
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("the map " + file + " cannot be used: " + e.what());
  }
}

}  // namespace vir::mission
