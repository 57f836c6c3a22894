#pragma once
/// Feeds the observations of a recording to vir::check.
#include <mrpt/obs/CObservation.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recordings/companion.h"
#include "vir/check/difference_check.h"
#include "vir/check/finding.h"
#include "vir/check/image_check.h"
#include "vir/check/imu_check.h"
#include "vir/check/range_check.h"
#include "vir/check/range_path.h"
#include "vir/check/rig_check.h"
#include "vir/check/stream_check.h"
#include "vir/check/turning_check.h"

namespace mrpt::obs {
class CObservationImage;
}

namespace vir::app {

class RecordingCheck {
 public:
  /// `brief`: stamps, IMU and ranges, at no cost to speak of. `full`: images are decoded and
  /// followed as well.
  enum class Depth { brief, full };
  explicit RecordingCheck(Depth depth);
  ~RecordingCheck();

  /// Densities that an estimator would use.
  void setNoise(const imu::ImuNoise& noise) { noise_ = noise; }
  /// Stamp of an image of the first camera + this = its time on the IMU's clock [s], as given.
  void setTimeOffset(double time_offset_s) { time_offset_s_ = time_offset_s; }
  /// The same of the cameras beside the first, in the order of their labels; of one that is not
  /// told that of the first.
  void setOtherTimeOffsets(std::vector<double> offsets_s) {
    other_time_offsets_s_ = std::move(offsets_s);
  }
  /// That reads the recording ("csv", "bag", ...), to be named in remedies; empty: not known.
  void setDriver(const std::string& driver) { driver_ = driver; }
  /// Where anchors are, as far as somebody says so.
  void setAnchors(check::GivenAnchors anchors) { anchors_ = std::move(anchors); }
  /// What anchors are called that have no number of their own: said instead of it.
  void setAnchorTexts(AnchorTexts texts) { anchor_texts_ = std::move(texts); }
  /// Loads an external image if need be (full), and lets go of it again.
  void add(const mrpt::obs::CObservation& observation);

  std::vector<check::StreamSummary> streams() const;
  /// The worst first.
  std::vector<check::Finding> findings() const;

 private:
  struct Camera;
  std::optional<check::Mounting> mountingOf(const check::TurningVerdict& turning,
                                            const std::string& imu) const;
  void nameOtherOffset(const std::string& label, std::string* text) const;
  void takeFurtherTurning(std::vector<check::Finding>* out) const;
  check::TurningCheck& turningOf(const std::string& camera);
  double timeOffsetOf(const std::string& camera) const;
  bool isFurtherCamera(const std::string& label) const;
  void calmFurther(std::vector<check::Finding>* findings) const;
  std::vector<check::Finding> stampFindings() const;
  void takeRanges(bool stamps, std::vector<check::Finding>* out) const;
  void takeImages(std::vector<check::Finding>* out) const;
  void addRanges(const mrpt::obs::CObservation& observation);
  void addImage(const mrpt::obs::CObservationImage& image, TimeNs t);
  /// The first camera and this one, if both have a calibration; nullptr for the first.
  check::RigCheck* rigOf(const std::string& label);
  bool wantedForRig(const std::string& label, TimeNs t);
  void addToRigs(const std::string& label, TimeNs t, const cv::Mat& gray);

  Depth depth_;
  std::string driver_;
  std::optional<imu::ImuNoise> noise_;
  double time_offset_s_ = 0;
  std::vector<double> other_time_offsets_s_;
  std::map<std::string, check::StreamCheck> streams_;
  std::map<std::string, check::ImuCheck> imus_;
  std::map<std::string, check::RangeCheck> ranges_;
  check::DifferenceCheck differences_;
  std::map<std::string, check::RangePathCheck> along_path_;  ///< full only
  check::KnownPath truth_, odometry_;                        ///< full only
  check::GivenAnchors anchors_;
  AnchorTexts anchor_texts_;
  std::map<std::string, std::unique_ptr<Camera>> cameras_;
  std::map<std::string, check::RigCheck> rigs_;   ///< of the first camera and this one; full only
  std::unique_ptr<check::TurningCheck> turning_;  ///< of the first camera and the first IMU
};

/// Those of findings() that are more than notes and concern none of the streams `but` [labels].
std::vector<check::Finding> doubtfulFindings(const RecordingCheck& check,
                                             const std::vector<std::string>& but = {});
/// The same, a line each.
std::vector<std::string> briefLines(const RecordingCheck& check,
                                    const std::vector<std::string>& but = {});

}  // namespace vir::app
