#include "setup/record_options.h"

#include "vir/core/ini_writer.h"
#include "vir/live/acquisition.h"

namespace vir::app {

void describe(OptionVisitor& v, RecordOptions& o) {
  v.section("Recording", "How a live recording is written, and what else is done with it");
  v.value("out", o.out,
          "rawlog; empty: the name of the ini with date and time. --out goes before it");
  v.value("duration_s", o.duration_s, {0, 1e9}, "end after so long; 0 = when it is stopped");
  v.value("delay_s", o.delay_s, {0, 10}, "how long the order of time waits for a late sensor");
  v.value("estimate", o.estimate, "estimate while recording, with the settings of this file");
  v.value("pipelined", o.pipelined, "estimate with tracking and optimisation in a thread each");
  v.value("stream_port", o.stream_port, {0, 65535}, "TCP port for poses as JSON lines; 0 = none");
  v.value("stream_address", o.stream_address, "of the interface to listen on; 0.0.0.0 = all");
  v.value("stream_clients", o.stream_clients, {1, 256}, "how many may be connected at a time");
  v.value("stream_token", o.stream_token,
          "what a client must send as its first line; empty: nothing. Set it with an address that "
          "others can reach");
  v.value("view", o.view, "a window with path, anchors and tracks, where there is a display");
  describe(v, o.file);
  describe(v, o.mavlink);
  describe(v, o.foxglove);
  describe(v, o.dds);
}

std::vector<std::string> sectionsOfSensors(const Settings& settings) {
  std::vector<std::string> all = live::sensorSections(settings);
  for (const std::string& section : settings.sections()) {
    const bool ignored = settings.find(section, kGrabberIgnore) != nullptr;
    if (ignored && settings.find(section, "process_rate") != nullptr) all.push_back(section);
  }
  all.emplace_back("global");
  return all;
}

void refuseMixedSections(const Settings& settings, const std::vector<std::string>& sensors,
                         roles::EstimatorSettings& estimator) {
  IniWriter writer(IniWriter::Style::values);
  estimator.describe(writer);
  const Settings own = Settings::fromText(writer.text(), "the estimator's settings");
  for (const std::string& sensor : sensors) {
    for (const Setting& s : own.all()) {
      const Setting* mixed = settings.find(sensor, s.key);
      if (mixed == nullptr || mixed != settings.find(s.section, s.key)) continue;
      throw SettingsError(*mixed, "[" + s.section +
                                      "] is the estimator's, and here a sensor's as well: give the "
                                      "sensor's section another name, e.g. [" +
                                      sensor + "0]");
    }
  }
}

}  // namespace vir::app
