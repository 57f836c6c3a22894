#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/options.h"
#include "vir/geometry/so3.h"
#include "vir/types/survey.h"

namespace vir::roles {

/// Among the counters of a source: places where it is damaged or was cut off, so that what comes of
/// it is a part only.
inline constexpr const char* kDamageCounter = "damage";

/// Among the counters of a source: streams that an estimator needs (camera, IMU, ranges) whose data
/// are there, and of which not one could be used.
inline constexpr const char* kUselessCounter = "streams_without_use";

/// Where an anchor truly is, in the world of the ground truth.
struct TrueAnchor {
  std::uint64_t id = 0;  ///< as that of its ranges (rawlog::rangesOf)
  Vec3 p_W = Vec3::Zero();
};

/// What a recorded or simulated sensor offers beside mrpt::hwdrivers::CGenericSensor, so that
/// `import` can run it at full speed. Order of calls: describe (reads the settings), initialize(),
/// then doProcess() and getObservations() until finished(). Observations come out in time order.
class RecordedSource {
 public:
  virtual ~RecordedSource() = default;
  /// Declares the settings of this source, `source` (the folder or file) among them.
  virtual void describe(OptionVisitor& v) = 0;
  /// How far it is, 0..1.
  virtual double progress() const = 0;
  /// True once every observation has been handed out.
  virtual bool finished() const = 0;
  /// What was read and what could not be used, e.g. {"images", 600}, {"images_missing", 1}.
  virtual std::vector<std::pair<std::string, long>> counters() const = 0;
  /// One line each, with file and line where that applies.
  virtual std::vector<std::string> warnings() const = 0;
  /// Settings an estimator should use with this recording (noise densities of its IMU, ...), as the
  /// text of an ini file; `import` writes it beside the rawlog. Valid after initialize(). Empty:
  /// nothing to say.
  virtual std::string companionIni() const { return {}; }
  /// For evaluation only, so not among the observations: `import` writes them beside the rawlog as
  /// `<name>_anchors_truth.csv`. Valid after initialize(); empty: not known.
  virtual std::vector<TrueAnchor> trueAnchors() const { return {}; }
  /// Positions of anchors that the recording itself tells with its ranges, in a frame of their own:
  /// `import` writes them beside the rawlog as `<name>_anchors.csv`, a table that `run --anchors`
  /// takes. Valid once finished(); empty: it tells none.
  virtual std::vector<SurveyedAnchor> surveyedAnchors() const { return {}; }
  /// Whether it knows how to read this file or folder, going by how it looks: `import SOURCE` asks
  /// everyone. Does not throw and needs no initialize().
  virtual bool canRead(const std::string& /*source*/) const { return false; }
  /// What is in `source`, as a table for people (`import --list`); empty: cannot tell. Throws
  /// std::runtime_error if it cannot be read.
  virtual std::string listing(const std::string& /*source*/) const { return {}; }
};

}  // namespace vir::roles
