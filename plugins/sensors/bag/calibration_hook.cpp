#include "calibration_hook.h"

#include "input_error.h"

namespace vir::bag {

CalibrationExtras applyCalibrationFile(const std::string& path, std::vector<CameraSetup>*,
                                       ProblemLog*) {
  throw InputError(path + ": calibration files cannot be read yet");
}

}  // namespace vir::bag
