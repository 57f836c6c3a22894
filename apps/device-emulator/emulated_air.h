#pragma once
/// The air between emulated radios of several processes: a folder with a socket for each.
#include <cstdint>
#include <string>
#include <vector>

#include "vir/core/random.h"

namespace vir::emulator {

struct AirOptions {
  std::string folder;  ///< empty: no air
  double lost = 0;     ///< share of packets that do not arrive
  double damaged = 0;  ///< share that arrives with one byte changed
  int seed = 1;
};

struct AirPacket {
  int sender = 0;
  std::string bytes;
};

class EmulatedAir {
 public:
  /// Throws std::runtime_error if the folder cannot be used.
  EmulatedAir(const AirOptions& options, int own_id);
  ~EmulatedAir();
  EmulatedAir(const EmulatedAir&) = delete;
  EmulatedAir& operator=(const EmulatedAir&) = delete;

  /// To all others that there are.
  void send(const std::string& bytes);
  /// What has come in since the last call.
  std::vector<AirPacket> take();

 private:
  AirOptions options_;
  int own_id_;
  std::string own_path_;
  Random random_;
  int socket_ = -1;
};

}  // namespace vir::emulator
