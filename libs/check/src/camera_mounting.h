#pragma once
/// What a rotation between camera and IMU that is not the one given is likely to come from.
#include <string>

#include "vir/check/finding.h"
#include "vir/geometry/so3.h"

namespace vir::check {

struct MountingFault {
  Finding finding;
  bool images_mirrored = false;  ///< the rotation found is then none of the camera's
};

/// `force_sign`: of the images against the accelerometer with the rotation found (ForceSign).
/// `evidence`: what speaks for it.
MountingFault mountingFault(const Mat3& R_B_C_given, const Mat3& R_B_C_found, int force_sign,
                            const std::string& camera_label, const std::string& evidence);

/// `x is -y, ...` of a matrix near a signed permutation; empty for any other.
std::string axesNamed(const Mat3& M);

}  // namespace vir::check
