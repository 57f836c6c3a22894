#pragma once
#include <string>
#include <vector>

#include "live/autopilot_link.h"
#include "live/foxglove_stream.h"
#include "vir/core/options.h"
#include "vir/core/settings.h"
#include "vir/dds/link.h"
#include "vir/rawlog/live_recording.h"
#include "vir/roles/estimator.h"

namespace vir::app {

/// Section [Recording] of a live ini.
struct RecordOptions {
  std::string out;        ///< rawlog; empty: <name of the ini>_<date-time>.rawlog
  double duration_s = 0;  ///< 0: until it is stopped
  double delay_s = 0.25;  ///< of the time order
  bool estimate = false;  ///< with the settings of the rest of the ini
  bool pipelined = true;  ///< tracking and optimisation in a thread each
  int stream_port = 0;    ///< poses as JSON lines; 0: none
  std::string stream_address = "127.0.0.1";
  int stream_clients = 16;
  std::string stream_token;  ///< empty: none
  bool view = false;         ///< a window, where there is a display
  rawlog::LiveRecordingOptions file;
  MavlinkOptions mavlink;
  FoxgloveOptions foxglove;
  dds::LinkOptions dds;
};

void describe(OptionVisitor& v, RecordOptions& o);

/// Sections of a live ini that are for sensors and for rawlog-grabber, those switched off included.
std::vector<std::string> sectionsOfSensors(const Settings& settings);
/// Sections are the same whatever their case. Throws SettingsError if a sensor's section holds a
/// setting of the estimator as well: neither could tell the other's from a mistake.
void refuseMixedSections(const Settings& settings, const std::vector<std::string>& sensors,
                         roles::EstimatorSettings& estimator);
/// What an ini says to rawlog-grabber only.
constexpr const char* kGrabberIgnore = "rawlog-grabber-ignore";

}  // namespace vir::app
