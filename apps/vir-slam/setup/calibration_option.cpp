#include "setup/calibration_option.h"

#include <CLI/CLI.hpp>

#include "vir/formats/calibration_file.h"

namespace vir::app {

void addCalibrationOption(CLI::App& command, std::string& files, const std::string& what) {
  command
      .add_option("--calibration", files,
                  what + "; again for another part, as Kalibr's camchain and imu.yaml")
      ->join(formats::kPathSeparator)
      ->allow_extra_args(false);
}

}  // namespace vir::app
