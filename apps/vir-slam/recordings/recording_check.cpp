#include "recordings/recording_check.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>

#include "recordings/checked_camera.h"
#include "vir/camera/camera_model.h"
#include "vir/check/intrinsics_check.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/range_differences.h"

namespace vir::app {
namespace {

using namespace mrpt::obs;

/// Images followed for turning; later ones are looked at now and then.
constexpr long kFollowed = 600, kLookEvery = 20;
/// Of cameras beside the first, which are not followed: often enough to see that one hangs.
constexpr long kLookAtFurtherEvery = 5;

check::StreamKind kindOf(const CObservation& o) {
  if (rawlog::isImage(o)) return check::StreamKind::images;
  if (dynamic_cast<const CObservationIMU*>(&o) != nullptr) return check::StreamKind::imu;
  if (dynamic_cast<const CObservationRobotPose*>(&o) != nullptr) return check::StreamKind::poses;
  return rawlog::rangesOf(o).empty() ? check::StreamKind::other : check::StreamKind::ranges;
}

}  // namespace

RecordingCheck::RecordingCheck(Depth depth) : depth_(depth) {}
RecordingCheck::~RecordingCheck() = default;

void RecordingCheck::add(const CObservation& o) {
  const std::string& label = o.sensorLabel;
  const TimeNs t = rawlog::fromMrptTime(o.timestamp);
  streams_.try_emplace(label, label, kindOf(o)).first->second.add(t);
  if (const auto sample = rawlog::imuSampleOf(o)) {
    using Keeps = check::ImuCheck::Keeps;
    const Keeps keeps = depth_ == Depth::full ? Keeps::all : Keeps::evenly;
    imus_.try_emplace(label, label, keeps).first->second.add(*sample);
    if (!turning_ && depth_ == Depth::full) {
      turning_ = std::make_unique<check::TurningCheck>(label, rawlog::kCameraLabel);
    }
    if (turning_ && label == imus_.begin()->first) {
      turning_->add(*sample);
      for (auto& [other, camera] : cameras_) {
        if (camera->own) camera->own->add(*sample);
      }
    }
  } else if (const auto* image = dynamic_cast<const CObservationImage*>(&o)) {
    addImage(*image, t);
  } else {
    addRanges(o);
  }
}

void RecordingCheck::addRanges(const CObservation& o) {
  const std::string& label = o.sensorLabel;
  const bool full = depth_ == Depth::full;
  for (const Range& r : rawlog::rangeDifferencesOf(o)) differences_.add(r);
  for (const Range& r : rawlog::rangesOf(o)) {
    ranges_.try_emplace(label, label).first->second.add(r);
    // Those to other robots have no anchor.
    if (full && label != rawlog::kPeerLabel) {
      along_path_.try_emplace(label, label).first->second.add(r);
    }
  }
  if (!full) return;
  const bool truth = label == rawlog::kGroundTruthLabel;
  if (!truth && label != rawlog::kOdometryLabel) return;
  if (const auto pose = rawlog::poseOf(o)) (truth ? truth_ : odometry_).add(*pose);
}

void RecordingCheck::addImage(const CObservationImage& image, TimeNs t) {
  auto& camera = cameras_[image.sensorLabel];
  if (!camera) {
    camera = std::make_unique<Camera>(image.sensorLabel);
    camera->calibration = rawlog::fromMrptCamera(image.cameraParams);
    camera->T_B_C = rawlog::fromMrptPose(image.cameraPose);
    camera->calibrated = camera->calibration.fx > 0 && camera->calibration.cx > 0;
    camera->intrinsics = check::intrinsicsFinding(camera->calibration, image.sensorLabel);
    // Turning seen through a lens that cannot be says nothing.
    const bool usable = camera->calibrated && !camera->intrinsics;
    if (usable && depth_ == Depth::full) {
      camera->turning =
          std::make_unique<check::ImageTurning>(camera::makeCamera(camera->calibration));
    }
  }
  if (depth_ == Depth::brief) return;
  const bool follow = camera->turning && camera->count < kFollowed;
  const bool paired = wantedForRig(image.sensorLabel, t);
  const bool further = image.sensorLabel != cameras_.begin()->first;
  const long every = further && camera->count < kFollowed ? kLookAtFurtherEvery : kLookEvery;
  if (camera->count++ % every != 0 && !follow && !paired) return;
  cv::Mat gray;
  try {
    image.load();
    gray = rawlog::grayOf(image);
  } catch (const std::exception& e) {
    camera->images.addUnreadable(rawlog::shortReason(e));
    return;
  }
  // A copy tells nothing of turning but that of the one before, at a wrong time.
  const bool fresh = camera->images.add(t, gray);
  if (paired) addToRigs(image.sensorLabel, t, gray);
  if (follow && fresh) {
    const auto turn = camera->turning->add(t, gray);
    camera->images.addCorners(camera->turning->corners());
    if (turn && turning_) {
      check::TurningCheck& against_gyro = turningOf(image.sensorLabel);
      against_gyro.setCamera(camera->calibration);
      against_gyro.add(*turn);
    }
  }
  if (image.image.isExternallyStored()) image.image.unload();
}

check::RigCheck* RecordingCheck::rigOf(const std::string& label) {
  const auto& [first_label, first] = *cameras_.begin();
  const auto of = cameras_.find(label);
  if (label == first_label || of == cameras_.end()) return nullptr;
  const auto sound = [](const Camera& c) { return c.calibrated && !c.intrinsics; };
  if (!sound(*first) || !sound(*of->second)) return nullptr;
  const auto known = rigs_.find(label);
  if (known != rigs_.end()) return &known->second;
  const Camera& second = *of->second;
  return &rigs_
              .try_emplace(label, check::RigCamera{first_label, first->calibration, first->T_B_C},
                           check::RigCamera{label, second.calibration, second.T_B_C})
              .first->second;
}

bool RecordingCheck::wantedForRig(const std::string& label, TimeNs t) {
  for (const auto& [other, camera] : cameras_) {
    const bool concerned = label == other || label == cameras_.begin()->first;
    const check::RigCheck* rig = concerned ? rigOf(other) : nullptr;
    if (rig != nullptr && rig->wants(t)) return true;
  }
  return false;
}

void RecordingCheck::addToRigs(const std::string& label, TimeNs t, const cv::Mat& gray) {
  const CameraCalibration& c = cameras_[label]->calibration;
  if (gray.cols != c.width || gray.rows != c.height) return;
  for (auto& [other, rig] : rigs_) {
    if (label == cameras_.begin()->first) {
      rig.add(0, t, gray);
    } else if (label == other) {
      rig.add(1, t + fromSeconds(timeOffsetOf(label) - time_offset_s_), gray);
    }
  }
}

std::vector<check::StreamSummary> RecordingCheck::streams() const {
  std::vector<check::StreamSummary> out;
  for (const auto& [label, stream] : streams_) out.push_back(stream.summary());
  return out;
}

/// How the first camera sits on the IMU, as far as it is known.
std::optional<check::Mounting> RecordingCheck::mountingOf(const check::TurningVerdict& turning,
                                                          const std::string& imu) const {
  if (cameras_.empty()) return std::nullopt;
  const auto& [label, camera] = *cameras_.begin();
  const bool ours = imu == imus_.begin()->first;
  if (ours && turning.R_B_C) {
    const bool given = turning.R_B_C->isApprox(camera->T_B_C.R(), 1e-9);
    return check::Mounting{*turning.R_B_C, label, turning.force, given};
  }
  // What turning speaks against says nothing of up. The identity is what is there when nobody has
  // said where the camera sits.
  const bool doubted = check::worst(turning.findings) == check::Severity::unusable;
  if (doubted || camera->T_B_C.R().isIdentity(1e-9)) return std::nullopt;
  return check::Mounting{camera->T_B_C.R(), label, {}};
}

namespace {

/// Adds what is not there yet: another look may have found the same.
void take(const std::vector<check::Finding>& more, std::vector<check::Finding>* out) {
  for (const check::Finding& f : more) {
    const bool known = std::any_of(out->begin(), out->end(), [&](const check::Finding& o) {
      return o.kind == f.kind && o.stream == f.stream && o.severity != check::Severity::note &&
             f.severity != check::Severity::note;
    });
    if (!known) out->push_back(f);
  }
}

template <typename Which>
void leaveOut(Which which, std::vector<check::Finding>* findings) {
  findings->erase(std::remove_if(findings->begin(), findings->end(), which), findings->end());
}

}  // namespace

std::vector<check::Finding> RecordingCheck::stampFindings() const {
  std::vector<check::Finding> out = check::checkStreams(streams());
  if (depth_ == Depth::brief) {
    // An estimator may do with less; it then says itself what it misses.
    leaveOut([](const check::Finding& f) { return f.kind == "no_imu"; }, &out);
  }
  calmFurther(&out);
  for (const auto& [label, imu] : imus_) {
    if (const auto stuck = imu.stuck()) out.push_back(*stuck);
    const auto copies = imu.copies();
    if (!copies) continue;
    // What is odd about its stamps then follows from that.
    leaveOut(
        [&name = label](const check::Finding& f) {
          return f.stream == name && (f.kind == "repeated" || f.kind == "rate" ||
                                      f.kind == "jitter" || f.kind == "bursts");
        },
        &out);
    out.push_back(*copies);
  }
  return out;
}

void RecordingCheck::takeRanges(bool stamps, std::vector<check::Finding>* out) const {
  take(differences_.findings(anchors_), out);
  for (const auto& [label, ranges] : ranges_) {
    const std::vector<check::Finding> of_ranges = ranges.findings();
    take(of_ranges, out);
    // What is known to be in another unit needs no path to say so.
    const auto ours = along_path_.find(label);
    const bool units = check::worst(of_ranges) != check::Severity::unusable;
    if (!stamps || ours == along_path_.end() || !units) continue;
    const check::RangePathCheck& along = ours->second;
    take(truth_.empty() ? along.againstOdometry(odometry_) : along.againstTruth(truth_, anchors_),
         out);
  }
}

void RecordingCheck::takeImages(std::vector<check::Finding>* out) const {
  const auto moves = [this](TimeNs from, TimeNs to) -> std::optional<bool> {
    const TimeNs offset = fromSeconds(time_offset_s_);
    if (imus_.empty()) return std::nullopt;
    return imus_.begin()->second.moves(from + offset, to + offset);
  };
  for (const auto& [label, camera] : cameras_) {
    const CameraCalibration& c = camera->calibration;
    if (camera->calibrated && camera->intrinsics) out->push_back(*camera->intrinsics);
    if (const auto far = check::mountingFinding(camera->T_B_C.p.norm(), label))
      out->push_back(*far);
    if (depth_ == Depth::brief) continue;
    take(camera->images.findings(camera->calibrated ? c.width : 0, c.height, moves,
                                 isFurtherCamera(label)),
         out);
    if (!camera->calibrated) {
      out->push_back({check::Severity::unusable, "no_calibration", label,
                      "the camera has no calibration", "", "give --calibration FILE"});
    }
  }
}

std::vector<check::Finding> RecordingCheck::findings() const {
  std::vector<check::Finding> out = stampFindings();
  const Camera* first = cameras_.empty() ? nullptr : cameras_.begin()->second.get();
  // What rests on the time between readings says nothing while stamps are wrong.
  const bool stamps = check::worst(out) != check::Severity::unusable;
  check::TurningVerdict turning;
  if (turning_ && first != nullptr && first->turning && stamps) {
    turning = turning_->verdict(first->T_B_C.R(), time_offset_s_);
  }
  for (const auto& [label, imu] : imus_) {
    if (!stamps) continue;
    const Vec3 bias = label == imus_.begin()->first ? turning.gyro_bias : Vec3::Zero();
    take(imu.findings(noise_, mountingOf(turning, label), turning.gyro_trusted, bias), &out);
  }
  takeRanges(stamps, &out);
  takeImages(&out);
  const auto path = [this](TimeNs t) { return truth_.poseAt(t + fromSeconds(time_offset_s_)); };
  for (const auto& [label, rig] : rigs_) {
    take(truth_.empty() ? rig.findings() : rig.findings(path), &out);
  }
  const bool gyro = std::none_of(out.begin(), out.end(), [](const check::Finding& f) {
    return f.kind == "imu_columns_swapped";
  });
  if (gyro) take(turning.findings, &out);
  const bool first_agrees = check::worst(turning.findings) == check::Severity::note;
  if (stamps && first_agrees) takeFurtherTurning(&out);
  calmFurther(&out);
  for (check::Finding& f : out) {
    nameDriver(driver_, &f);
    for (std::string* text : {&f.what, &f.evidence, &f.remedy}) callAnchors(anchor_texts_, text);
  }
  std::stable_sort(out.begin(), out.end(), [](const check::Finding& a, const check::Finding& b) {
    return a.severity > b.severity;
  });
  return out;
}

std::vector<check::Finding> doubtfulFindings(const RecordingCheck& check,
                                             const std::vector<std::string>& but) {
  std::vector<check::Finding> out = check.findings();
  leaveOut(
      [&](const check::Finding& f) {
        return f.severity == check::Severity::note ||
               std::find(but.begin(), but.end(), f.stream) != but.end();
      },
      &out);
  return out;
}

std::vector<std::string> briefLines(const RecordingCheck& check,
                                    const std::vector<std::string>& but) {
  std::vector<std::string> out;
  for (const check::Finding& f : doubtfulFindings(check, but)) out.push_back(check::line(f));
  return out;
}

}  // namespace vir::app
