/// A folder of tables and images with damage to one of its files, or any bytes in its place: finite
/// readings in the order of time, or InputError. One program per kind (VIR_FUZZ_KIND: euroc, csv):
///   VIR_FUZZ_BYTES=10000000 fuzz_folder_csv -max_len=256 -entropic=0
/// (with its entropic schedule the fuzzer itself takes a quarter of the time).
#include <array>
#include <opencv2/imgcodecs.hpp>

#include "fuzz_damage.h"
#include "fuzz_folder.h"
#include "fuzz_memory.h"
#include "image_store.h"
#include "input_error.h"
#include "recording.h"
#include "table_folder.h"

namespace {

using namespace vir::euroc;

const bool kEuroc = std::string(VIR_FUZZ_KIND) == "euroc";
constexpr const char* kIdentity =
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]\n";

/// Files with their good content.
std::vector<std::pair<std::string, std::string>> goodFiles() {
  std::string imu = "#timestamp [ns],wx,wy,wz,ax,ay,az\n", images = "#timestamp [ns],filename\n";
  std::string ranges = "#timestamp [ns],anchor_id,range [m]\n", truth = "#t,x,y,z,qw,qx,qy,qz\n";
  for (int i = 0; i < 12; ++i) {
    const std::string t = "14036365800" + std::to_string(10 + i) + "000000";
    imu += t + ",0.1,0.02,0.03,0.1,0.2,9.81\n";
    truth += t + ",1,2,3,1,0,0,0\n";
    if (i % 4 == 0) images += t + "," + std::to_string(i / 4) + ".png\n";
    if (i % 3 == 0) ranges += t + ",0x8" + std::to_string(i % 2) + ",2.5\n";
  }
  const std::string camera =
      std::string(kIdentity) +
      "resolution: [16, 12]\nintrinsics: [10, 11, 8, 6]\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
  const std::string noise = std::string(kIdentity) +
                            "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n"
                            "accelerometer_noise_density: 2e-3\naccelerometer_random_walk: 3e-3\n";
  std::vector<unsigned char> png;
  cv::imencode(".png", cv::Mat(12, 16, CV_8UC1, cv::Scalar(50)), png);
  const std::string anchors = "#id,x,y,z\n0x80,1,2,3\n0x81,2,3,4\n";
  const std::string picture(png.begin(), png.end());
  if (!kEuroc) {
    return {{"imu.csv", imu},        {"images.csv", images},  {"uwb.csv", ranges},
            {"gt.csv", truth},       {"cam.yaml", camera},    {"anchors.csv", anchors},
            {"data/0.png", picture}, {"data/1.png", picture}, {"data/2.png", picture}};
  }
  return {{"mav0/imu0/data.csv", imu},
          {"mav0/cam0/data.csv", images},
          {"mav0/uwb0/data.csv", ranges},
          {"mav0/state_groundtruth_estimate0/data.csv", truth},
          {"mav0/cam0/sensor.yaml", camera},
          {"mav0/uwb0/anchors_truth.csv", anchors},
          {"mav0/imu0/sensor.yaml", noise},
          {"mav0/cam0/data/0.png", picture},
          {"mav0/uwb0/sensor.yaml", std::string(kIdentity) + "range_noise_sigma: 0.07\n"}};
}

void readAll(const EurocOptions& options) {
  vir::ProblemLog log;
  Recording recording =
      kEuroc ? Recording(options, &log) : Recording(findTables(options), options, &log);
  std::unique_ptr<ImageStore> store;
  if (!recording.cameras().empty()) {
    const CameraStream& c = recording.cameras()[0];
    store = std::make_unique<ImageStore>(ImageMode::embed, "", "CAM0", c.file_width, c.file_height,
                                         &log);
    store->setTarget(c.calibration.camera.width, c.calibration.camera.height);
    store->setStretch(c.stretch.black, c.stretch.white, c.stretch.eight_bit);
  }
  Event event;
  vir::TimeNs last = 0;
  while (recording.next(&event)) {
    if (event.t < last) std::abort();
    last = event.t;
    if (const auto* imu = std::get_if<vir::ImuSample>(&event.what)) {
      if (!imu->gyro.allFinite() || !imu->acc.allFinite()) std::abort();
    } else if (const auto* image = std::get_if<ImageRow>(&event.what)) {
      StoredImage stored;
      store->store(event.t, imageFile(recording.cameras()[event.stream].files.dir, image->file),
                   event.where, &stored);
    } else if (const auto* pose = std::get_if<PoseRow>(&event.what)) {
      if (!pose->T_W_B.p.allFinite()) std::abort();
    }
  }
}

}  // namespace

/// Every allocation keeps its stack and its bytes for a while, which is a fifth of the time.
extern "C" const char* __asan_default_options() {  // NOLINT: the sanitizer's name
  return "malloc_context_size=4:quarantine_size_mb=16";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vir::fuzz::Folder folder;
  static const auto files = [] {
    auto all = goodFiles();
    for (const auto& [name, text] : all) folder.write(name, text);
    return all;
  }();
  if (size < 2) return 0;
  const auto& [name, good] = files[data[0] % files.size()];
  const std::string bytes = vir::fuzz::input(data + 1, size - 1, good);
  folder.write(name, bytes);
  {
    // Any image may claim 16 megapixels, in colour, and be copied.
    const vir::fuzz::MemoryWatch watch(bytes.size() + 8192, 40, 192 << 20);
    try {
      EurocOptions options;
      options.section = VIR_FUZZ_KIND;
      options.source = folder.path().string();
      // Whether it is one is half of the work, and is looked at again.
      const bool ask = !kEuroc && data[0] < 64;
      if (!ask || isTableFolder(options.source)) readAll(options);
    } catch (const vir::InputError&) {
    }
  }
  folder.write(name, good);
  vir::fuzz::count(bytes.size());
  return 0;
}
