/// Any bytes, or damage to a good rawlog, plain or compressed: it ends, takes no more memory than
/// its bound, and what comes out is what the rest of the program may rely on.
///   VIR_FUZZ_BYTES=10000000 fuzz_rawlog -max_len=256 -rss_limit_mb=2048
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "fuzz_damage.h"
#include "vir/rawlog/live_recording.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/plausible.h"
#include "vir/rawlog/rawlog_reader.h"

namespace {

using namespace mrpt::obs;

/// One object of every kind that an estimator takes, not compressed.
std::string goodFile() {
  const std::string path = "/tmp/vir_fuzz_" + std::to_string(getpid()) + ".rawlog";
  vir::rawlog::LiveRecordingOptions options;
  options.images = "embed";
  vir::rawlog::LiveRecording out(path, options);
  vir::TimeNs t = 1'700'000'000'000'000'000;
  const auto put = [&](CObservation& o, const char* label) {
    o.sensorLabel = label;
    o.timestamp = vir::rawlog::toMrptTime(t += 1'000'000);
    out.write(o, true);
  };
  CObservationIMU imu;
  imu.set(IMU_Z_ACC, 9.81);
  put(imu, "IMU0");
  CObservationImage image;
  image.image.resize(16, 12, mrpt::img::CH_GRAY);
  put(image, "CAM0");
  CObservationImage external;
  external.image.setExternalStorage("CAM0_1.png");
  CObservationBeaconRanges ranges;
  ranges.sensedData.resize(2);
  put(ranges, "UWB0");
  CObservationRobotPose pose;
  put(pose, "GT");
  out.close();
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  unlink(path.c_str());
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = goodFile();
  if (good.empty()) std::abort();
  const std::string bytes = vir::fuzz::input(data, size, good);
  if (bytes.empty()) return 0;
  static const int memory = memfd_create("fuzz", 0);
  if (ftruncate(memory, 0) != 0 || pwrite(memory, bytes.data(), bytes.size(), 0) < 0) std::abort();
  vir::rawlog::RawlogReader reader("/proc/self/fd/" + std::to_string(memory));
  while (const auto o = reader.next()) {
    if (!vir::rawlog::implausible(*o).empty()) std::abort();
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
