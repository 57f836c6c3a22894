#pragma once
/// What settings and the first images say of how a stream is to be read.
#include "euroc_options.h"
#include "recording.h"

namespace vir::euroc {

Units unitsOf(const EurocOptions& o);

/// The images of a camera, from files or a video. `imu_start`: of the IMU's first reading; empty:
/// there is no IMU.
std::unique_ptr<RowStream<ImageRow>> openCameraImages(const EurocOptions& o,
                                                      const CameraFiles& files,
                                                      std::optional<TimeNs> imu_start,
                                                      ProblemLog* log);

/// Looks at some images: stretch of 16 bits, and intrinsics for images of another size than the
/// calibration's. They become as wide as the options say.
void fitToImages(const EurocOptions& o, CameraStream* camera, ProblemLog* log);

}  // namespace vir::euroc
