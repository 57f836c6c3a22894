/// Images of the cameras of a rig, until all of them are known and after.
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "vir/core/text.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir_estimator.h"

namespace vir {
namespace {

constexpr int kMostOthers = 7;
/// Of the first camera: by then the others have come as well, if they are half as fast at least.
constexpr long kImagesBeforeStart = 3;

}  // namespace

std::vector<std::string> VirSettings::otherCameraLabels() const {
  std::vector<std::string> out;
  if (other_cameras == "auto") {
    for (int k = 1; k <= kMostOthers; ++k) {
      out.push_back(rawlog::furtherLabel(rawlog::kCameraLabel, std::to_string(k)));
    }
  } else if (other_cameras != "none") {
    std::string labels = other_cameras;
    std::replace(labels.begin(), labels.end(), ',', ' ');
    std::istringstream in(labels);
    for (std::string label; in >> label;) out.push_back(label);
  }
  out.erase(std::remove(out.begin(), out.end(), camera_label), out.end());
  return out;
}

VirEstimator::Camera* VirEstimator::cameraOf(const std::string& label) {
  for (Camera& c : cameras_) {
    if (c.label == label) return &c;
  }
  return nullptr;
}

bool VirEstimator::knowsOther(const mrpt::obs::CObservationImage& o, Camera* camera) {
  if (camera->refused || (rig_started_ && camera->number == 0)) {
    if (!camera->refused) {
      warnOnce(camera->label, camera->label +
                                  " began later than the first camera: its images are "
                                  "not used");
    }
    return false;
  }
  if (camera->mount) return true;
  CameraMount mount;
  mount.camera = rawlog::fromMrptCamera(o.cameraParams);
  mount.T_B_C = rawlog::fromMrptPose(o.cameraPose);
  const auto place = static_cast<std::size_t>(camera - cameras_.data()) - 1;
  const std::vector<double>& offsets = settings_.other_time_offsets_s;
  mount.time_offset_s =
      place < offsets.size() ? offsets[place] : settings_.config.camera_time_offset_s;
  mount.readout_s = settings_.config.window.readout_s;
  camera->mount = mount;
  return true;
}

/// The first camera has shown itself a few times, and so have the others, whoever came first.
void VirEstimator::startRig() {
  if (rig_started_) return;
  for (Camera& c : cameras_) {
    if (!c.mount || c.refused) continue;
    const Pose first = estimator_->givenCalibration().T_B_C;
    std::string why;
    const Pose apart = first.inverse() * c.mount->T_B_C;
    if (apart.p.norm() < 1e-6 && logQuat(apart.q).norm() < 1e-6) {
      why = "the recording has it where the first camera is";
    } else {
      try {
        c.number = estimator_->addCamera(*c.mount);
      } catch (const std::exception& e) {
        why = rawlog::shortReason(e);
      }
    }
    if (why.empty()) continue;
    c.refused = true;
    warnOnce(c.label, "images of " + c.label + " are not used: no usable calibration (" + why +
                          "); give --calibration FILE with both cameras, or [Estimator] "
                          "other_cameras = none");
  }
  rig_started_ = true;
  for (const auto& action : std::exchange(held_, {})) action();
}

void VirEstimator::addImage(const mrpt::obs::CObservationImage& o, Camera* camera) {
  const TimeNs t = rawlog::fromMrptTime(o.timestamp);
  if (camera->first) {
    if (!knowsCamera(o.cameraParams, o.cameraPose)) return;
    any_image_ = true;
  } else if (!any_image_ || !knowsOther(o, camera)) {
    return;  // nothing to begin with yet
  }
  ++camera->images;
  cv::Mat gray;
  try {
    gray = rawlog::grayOf(o);
  } catch (const std::exception& e) {
    ++camera->undecodable;
    warnOnce("decode " + camera->label,
             "images " + (camera->first ? std::string() : "of " + camera->label + " ") +
                 "that cannot be decoded are skipped; first at " + std::to_string(t) +
                 " ns: " + rawlog::shortReason(e).substr(0, 200));
  }
  if (!rig_started_) gray = gray.clone();  // the caller's pixels do not last
  if (camera->first) {
    inTurn([this, t, gray] { addFirstImage(t, gray); });
    if (camera->images >= kImagesBeforeStart) startRig();
  } else {
    inTurn([this, t, gray, camera] {
      if (camera->number > 0) estimator_->addImage(t, gray, camera->number);
    });
  }
}

void VirEstimator::reportRig(const estimator::EstimatorCounters& c,
                             roles::EstimatorReport* r) const {
  for (const Camera& camera : cameras_) {
    if (camera.number == 0) continue;
    const auto place = static_cast<std::size_t>(camera.number) - 1;
    const std::string name = lowerCase(camera.label) + "_";
    r->counters.emplace_back(name + "images", camera.images);
    r->counters.emplace_back(name + "undecodable", camera.undecodable);
    if (place >= c.further.size()) continue;
    r->counters.emplace_back(name + "taken", c.further[place].taken);
    r->counters.emplace_back(name + "without_partner", c.further[place].without_partner);
    r->counters.emplace_back(name + "unusable", c.further[place].unusable);
    r->counters.emplace_back(name + "out_of_order", c.further[place].out_of_order);
  }
  if (!c.further.empty()) r->counters.emplace_back("images_alone", c.images_alone);
}

}  // namespace vir
