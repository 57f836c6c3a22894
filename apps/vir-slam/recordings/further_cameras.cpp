/// Cameras beside the first, which runs leave alone unless they are told otherwise.
#include <algorithm>
#include <cstdio>
#include <iterator>

#include "recordings/checked_camera.h"

namespace vir::app {

bool RecordingCheck::isFurtherCamera(const std::string& label) const {
  return cameras_.count(label) > 0 && label != cameras_.begin()->first;
}

/// A camera that a run leaves alone unless it is told otherwise makes no recording unusable.
void RecordingCheck::calmFurther(std::vector<check::Finding>* findings) const {
  for (check::Finding& f : *findings) {
    if (f.severity != check::Severity::unusable || !isFurtherCamera(f.stream)) continue;
    f.severity = check::Severity::doubtful;
    f.remedy += (f.remedy.empty() ? "" : "; ") +
                std::string(
                    "until then leave it alone, as runs do by default: `[Estimator] "
                    "other_cameras = none`");
  }
}

/// The first by its label is held against the gyro, whichever came first; others by themselves.
check::TurningCheck& RecordingCheck::turningOf(const std::string& camera) {
  if (!isFurtherCamera(camera)) return *turning_;
  std::unique_ptr<check::TurningCheck>& own = cameras_[camera]->own;
  if (!own) own = std::make_unique<check::TurningCheck>(imus_.begin()->first, camera);
  return *own;
}

double RecordingCheck::timeOffsetOf(const std::string& camera) const {
  const auto place = std::distance(cameras_.begin(), cameras_.find(camera));
  const auto other = static_cast<std::size_t>(place) - 1;
  return place > 0 && other < other_time_offsets_s_.size() ? other_time_offsets_s_[other]
                                                           : time_offset_s_;
}

/// What turning says of cameras beside the first, of themselves: where the first agrees with the
/// gyro, it is not the gyro.
void RecordingCheck::takeFurtherTurning(std::vector<check::Finding>* out) const {
  for (const auto& [label, camera] : cameras_) {
    if (!camera->own) continue;
    for (check::Finding f : camera->own->findings(camera->T_B_C.R(), timeOffsetOf(label))) {
      if (f.stream != label || f.severity == check::Severity::note) continue;
      if (f.kind == "time_offset") {
        nameOtherOffset(label, &f.remedy);
        // That the two do not see the same then follows.
        const auto follows = [&name = label](const check::Finding& o) {
          return o.stream == name && o.kind == "rig_geometry" &&
                 o.severity == check::Severity::note;
        };
        out->erase(std::remove_if(out->begin(), out->end(), follows), out->end());
      }
      out->push_back(std::move(f));
    }
  }
}

/// The setting of a camera beside the first is one number of a list.
void RecordingCheck::nameOtherOffset(const std::string& label, std::string* text) const {
  const std::string of_first = "--set Camera.time_offset_s=";
  const std::size_t at = text->find(of_first);
  if (at == std::string::npos) return;
  std::string list = "Camera.other_time_offsets_s=";
  for (auto other = std::next(cameras_.begin()); other->first != label; ++other) {
    char number[32];
    std::snprintf(number, sizeof number, "%.6g ", timeOffsetOf(other->first));
    list += number;
  }
  const std::size_t value = at + of_first.size();
  const std::size_t end = std::min(text->find(';', value), text->size());
  list += text->substr(value, end - value);
  text->replace(at, end - at, "--set \"" + list + "\"");
}

}  // namespace vir::app
