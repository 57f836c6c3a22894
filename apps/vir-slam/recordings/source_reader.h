#pragma once
/// The observations of a rawlog, or of any recording that `import` reads, without writing a file.
#include <mrpt/obs/CObservation.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "recordings/companion.h"
#include "vir/check/range_path.h"
#include "vir/roles/recorded_source.h"

namespace vir::app {

/// By its name.
bool isRawlog(const std::string& source);

struct SourceToRead {
  std::string source;                    ///< rawlog, folder or file
  std::vector<std::string> set;          ///< Section.key=value of the source's driver
  std::string calibration;               ///< file; empty: none
  std::vector<std::string> topics = {};  ///< ROLE=NAME each; not of a rawlog
};

/// What the reader has to say.
struct SourceReport {
  std::vector<std::string> notes;
  std::string driver;    ///< that read it; empty: a rawlog
  bool damaged = false;  ///< or cut off: there should be more
  long by_position = 0;  ///< tables whose columns were taken by their place, names unknown
  long not_read = 0;     ///< tables that are called after a stream which no other table has
  long useless = 0;      ///< streams whose data are there, and none could be used
  long too_late = 0;     ///< rows that came after later ones, by more than can be put in order
  /// Lines and messages that are no readings: name of the counter and how many, none with 0.
  std::vector<std::pair<std::string, long>> unreadable;
  long imu_repeated = 0;        ///< readings left out because another one has their stamp
  AnchorTexts anchor_texts;     ///< what those of a name are called
  check::GivenAnchors anchors;  ///< where they are, as the source or the files beside it say
};

/// Of a source that was read to its end.
SourceReport reportOf(const roles::RecordedSource& source);

/// Calls `visit` for every observation with the part read (0..1). Throws UsageError, SettingsError,
/// std::runtime_error. Plugins must be loaded.
SourceReport readSource(
    const SourceToRead& what,
    const std::function<void(mrpt::obs::CObservation& observation, double part)>& visit);

}  // namespace vir::app
