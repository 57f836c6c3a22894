/// Images of the cameras of a rig, until all of them are known and after.
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <stdexcept>
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

/// Pairs whose cameras should see the same, and match less of it than this, are no pairs. After so
/// many sights. Fewer than usual tell something only where something else does.
constexpr double kHardlyMatched = 0.08, kSeldomMatched = 0.3;
constexpr long kEnoughLookedFor = 2000;
/// Of so many images, fewer than this part fit to any of the first camera in time.
constexpr long kEnoughImages = 40;
constexpr double kHardlyInTime = 0.3;
/// A baseline that comes out as another by more than this part of it, and this [m].
constexpr double kOtherBaseline = 0.02, kOtherBaselineM = 0.001;
/// One that is held pulls to another by this part of it and so many sigmas. Right calibrations were
/// pulled by up to 1.4 sigmas, of MH01 and simulated flights; those 5 % off by 4.0 at least.
constexpr double kPulledBaseline = 0.015, kContradictedSigmas = 3;
/// What the sights tell is less than this part of what is assumed: nothing.
constexpr double kLeastTold = 0.01;

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
  return text;
}

std::string metres(double m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4f m", m);
  return text;
}

/// What the sights and the IMU alone would have a distance be that is held at what was given [m]:
/// it follows them by as much as they know of it against what was assumed. Empty where they do not
/// contradict what was given.
std::optional<double> pulledTo(double given, double now, const window::RigDistance& d) {
  const double assumed = d.assumed_sigma_m * d.assumed_sigma_m;
  const double told =
      assumed - d.sigma_m * d.sigma_m;  // variance of the way it goes if all is well
  if (!(told > kLeastTold * assumed)) return std::nullopt;
  if (std::abs(now - given) < kContradictedSigmas * std::sqrt(told)) return std::nullopt;
  const double alone = given + (now - given) * assumed / told;
  if (std::abs(alone - given) < kPulledBaseline * given) return std::nullopt;
  return alone;
}

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
  if (other_cameras == "auto") {
    out.erase(std::remove(out.begin(), out.end(), camera_label), out.end());
  }
  return out;
}

void VirSettings::requireOtherCameras() const {
  std::vector<std::string> named{camera_label};
  for (const std::string& label : otherCameraLabels()) {
    if (std::find(named.begin(), named.end(), label) != named.end()) {
      throw std::invalid_argument(
          "[Estimator] other_cameras: " + label +
          (label == camera_label ? " is the camera_label already" : " is named twice") +
          "; name each camera beside " + camera_label + " once");
    }
    named.push_back(label);
  }
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
    r->counters.emplace_back(name + "looked_for", c.further[place].looked_for);
    r->counters.emplace_back(name + "matched", c.further[place].matched);
  }
  if (!c.further.empty()) r->counters.emplace_back("images_alone", c.images_alone);
}

/// What the rig's calibration explains comes before what else could.
void VirEstimator::doubtRig(const estimator::EstimatorCounters& c,
                            roles::EstimatorReport* r) const {
  const Calibration given = estimator_->givenCalibration(), found = estimator_->calibration();
  std::vector<std::string> doubts;
  for (std::size_t k = 0; k < given.further.size(); ++k) {
    const auto camera = std::find_if(cameras_.begin(), cameras_.end(), [k](const Camera& x) {
      return x.number == static_cast<int>(k) + 1;
    });
    const std::string& label = camera->label;
    r->further_labels.push_back(label);
    if (k >= c.further.size()) continue;
    const double used = static_cast<double>(c.further[k].taken + c.further[k].unusable);
    if (std::min(c.further[k].images, c.images) >= kEnoughImages &&
        used < kHardlyInTime * static_cast<double>(std::min(c.further[k].images, c.images))) {
      doubts.push_back(std::to_string(c.further[k].out_of_order) + " of " +
                       std::to_string(c.further[k].images) + " images of " + label +
                       " were left out: none of " + cameras_.front().label +
                       " is of their time; their clocks are apart ([Camera] other_time_offsets_s)");
    }
    if (c.further[k].looked_for < kEnoughLookedFor) continue;
    const double matched =
        static_cast<double>(c.further[k].matched) / static_cast<double>(c.further[k].looked_for);
    if (matched < (estimator_->doubts().empty() ? kHardlyMatched : kSeldomMatched)) {
      doubts.push_back(label + " should see what " + cameras_.front().label +
                       " sees, as their calibration has it, but only " + percent(matched) +
                       " of it was found there: one of their poses is wrong, left "
                       "and right are swapped, or their clocks are apart ([Camera] "
                       "other_time_offsets_s); `vir-slam check` looks which");
      continue;
    }
    const double b = (given.T_B_C.inverse() * given.further[k].T_B_C).p.norm();
    const std::vector<window::RigDistance> distances = estimator_->rigDistances();
    const double now = (found.T_B_C.inverse() * found.further[k].T_B_C).p.norm();
    const bool moved = std::abs(now - b) >= std::max(kOtherBaselineM, kOtherBaseline * b);
    const auto pulled =
        k < distances.size() ? pulledTo(b, now, distances[k]) : std::optional<double>();
    if (!moved && !pulled) continue;
    const std::string what = "the distance of " + label + " from " + cameras_.front().label +
                             " comes out as " + metres(moved ? now : *pulled) + ", given are " +
                             metres(b);
    if (!moved) {
      doubts.push_back(what +
                       ": it was held near what is given, but camera and IMU agree on "
                       "another; measure it");
    } else if (estimator_->doubts().empty()) {
      r->warnings.push_back(what + ": calibration.yaml has what was found");
    } else {
      doubts.push_back(what + ": a wrong one makes camera and IMU contradict each other");
    }
  }
  r->doubts.insert(r->doubts.begin(), doubts.begin(), doubts.end());
}

}  // namespace vir
