#pragma once
/// What is kept of a mission for the next one: places with the points seen there, anchors, the
/// camera.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vir/geometry/level_transform.h"
#include "vir/types/anchor.h"
#include "vir/types/calibration.h"
#include "vir/types/loop.h"
#include "vir/types/state.h"

namespace vir::mission {

/// In the map's frame M, z up: what is called W in its parts is M.
struct MissionMap {
  Calibration calibration;  ///< of the camera whose corners these are
  std::vector<std::shared_ptr<const PlaceKeyframe>> keyframes;  ///< ids rise
  std::vector<Anchor> anchors;  ///< those with a position, ordered by id
};

/// Corners of a keyframe at T_M_B that are known to `max_sigma` of their distance, as points in M,
/// appended with ids that count on.
void addMapPoints(const PlaceKeyframe& keyframe, const Pose& T_M_B, double max_sigma,
                  std::vector<Landmark>* points);

/// The bytes of a map file: docs/loops.md has the layout. The same map gives the same bytes. Pixels
/// are rounded to 1/16 px, rays to 1e-4 rad, inverse distances to 2e-4 of themselves.
std::string encode(const MissionMap& map);
/// Throws std::runtime_error that says what is wrong: no map, of another version, damaged (the
/// checksum does not fit), or with values that no map can have. Nothing is allocated that `bytes`
/// cannot fill.
MissionMap decode(const std::string& bytes);

/// Written beside and renamed when it is on the disk: a failure leaves what was there before.
/// Throws std::runtime_error naming the file, also for a map without keyframes: there is nothing in
/// it that a run could be found by.
void saveMap(const MissionMap& map, const std::string& file);
/// Throws std::runtime_error naming the file, also for a map without keyframes.
MissionMap loadMap(const std::string& file);

/// Empty if corners of the two cameras can be compared, else what differs: model, size of the
/// image, focal length or principal point by more than one sigma of a calibration can explain.
std::string cameraDifference(const CameraCalibration& map, const CameraCalibration& camera);

/// Everything moved by T, M' to M.
MissionMap moved(const MissionMap& map, const LevelTransform& T);

}  // namespace vir::mission
