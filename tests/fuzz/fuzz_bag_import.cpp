/// As fuzz_bag.cpp, through all that an import does with a bag: the choice of topics, calibration,
/// images, ranges, order of time. One program per fixture (VIR_FUZZ_SOURCE), a file or a folder, of
/// which one file is damaged:
///   VIR_FUZZ_BYTES=10000000 fuzz_import_ros1 -max_len=256
#include <algorithm>
#include <vector>

#include "bag_recording.h"
#include "fuzz_damage.h"
#include "fuzz_folder.h"
#include "fuzz_memory.h"
#include "input_error.h"

namespace {

namespace fs = std::filesystem;

/// Names and contents, a single file under its own name.
std::vector<std::pair<std::string, std::string>> goodFiles() {
  std::vector<std::pair<std::string, std::string>> files;
  const fs::path source = VIR_FUZZ_SOURCE;
  if (!fs::is_directory(source)) {
    files.emplace_back(source.filename().string(), vir::fuzz::Folder::readFile(source.string()));
    return files;
  }
  for (const auto& entry : fs::directory_iterator(source)) {
    files.emplace_back("bag/" + entry.path().filename().string(),
                       vir::fuzz::Folder::readFile(entry.path().string()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vir::fuzz::Folder folder;
  static const auto files = [] {
    auto all = goodFiles();
    for (const auto& [name, text] : all) folder.write(name, text);
    return all;
  }();
  if (files.empty() || files[0].second.empty()) std::abort();
  if (size < 2) return 0;
  const auto& [name, good] = files[data[0] % files.size()];
  const std::string bytes = vir::fuzz::input(data + 1, size - 1, good, 1);
  folder.write(name, bytes);
  std::size_t whole = bytes.size();
  for (const auto& f : files) whole += f.second.size();
  {
    // As in fuzz_bag.cpp.
    const vir::fuzz::MemoryWatch watch(whole, 4, 192 << 20);
    try {
      vir::ProblemLog log;
      vir::bag::BagOptions options;
      const bool is_folder = name.rfind("bag/", 0) == 0;
      options.source = (folder.path() / (is_folder ? "bag" : name)).string();
      options.need_calibration = false;
      options.images = data[1] % 2 == 0 ? "files" : "embed";
      vir::bag::BagRecording recording(options, &log);
      vir::bag::Reading reading;
      while (recording.next(&reading)) {
        if (const auto* imu = std::get_if<vir::ImuSample>(&reading.what)) {
          if (!imu->gyro.allFinite() || !imu->acc.allFinite()) std::abort();
        }
        recording.progress();
      }
    } catch (const vir::InputError&) {
    } catch (const vir::bags::BagError&) {
    }
  }
  folder.write(name, good);
  vir::fuzz::count(bytes.size());
  return 0;
}
