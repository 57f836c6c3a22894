/// As fuzz_range_parser.cpp, for the protocols of the IMU driver.
#include <cmath>

#include "fuzz_damage.h"
#include "imu_parser.h"
#include "messages.h"

namespace {

using vir::serial_imu::ImuReading;

constexpr std::size_t kMostHeld = 2048;

std::vector<ImuReading> run(const std::string& bytes, std::size_t piece) {
  vir::serial_imu::MavlinkOptions mavlink;
  const auto parser = vir::serial_imu::makeParser(VIR_FUZZ_PROTOCOL, {}, mavlink);
  std::vector<ImuReading> readings;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const std::vector<std::uint8_t> part(
        bytes.begin() + static_cast<std::ptrdiff_t>(at),
        bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at + piece, bytes.size())));
    parser->feed(part.data(), part.size(), &readings);
    if (parser->buffered() > kMostHeld) std::abort();
  }
  for (const ImuReading& r : readings) {
    for (const double v : r.acc_m_s2) {
      if (!(std::abs(v) <= 320)) std::abort();
    }
  }
  return readings;
}

std::string goodStream() {
  std::string bytes;
  for (const std::string& name : vir::emulator::imuProtocols()) {
    if (name.rfind(VIR_FUZZ_PROTOCOL, 0) != 0) continue;
    vir::emulator::ImuMessage m;
    m.device_time = 1234567000;
    m.acc_m_s2 = {0.1, -0.2, 9.8};
    m.gyro_rad_s = {0.01, 0.02, -0.03};
    bytes += vir::emulator::imuEncoder(name)(m);
  }
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = goodStream();
  const std::string bytes = vir::fuzz::input(data, size, good);
  const auto whole = run(bytes, bytes.size() + 1);
  const auto pieces = run(bytes, size % 11 + 1);
  if (whole.size() != pieces.size()) std::abort();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i].device_time != pieces[i].device_time) std::abort();
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
