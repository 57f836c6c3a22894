#include "vir/roles/grabber_settings.h"

#include "vir/core/settings.h"
#include "vir/roles/sensor_section.h"

namespace vir::roles {
namespace {

/// Reads every declared section from the one the user named.
class InstanceReader : public SettingsReader {
 public:
  InstanceReader(const Settings& settings, std::string instance)
      : SettingsReader(settings), instance_(std::move(instance)) {}
  void section(const std::string&, const std::string& doc) override {
    SettingsReader::section(instance_, doc);
  }

 private:
  std::string instance_;
};

}  // namespace

void readGrabberSection(const mrpt::config::CConfigFileBase& config, const std::string& section,
                        const std::function<void(OptionVisitor&)>& describe) {
  const Settings settings = Settings::fromMrpt(config, section, "ini");
  InstanceReader reader(settings, section);
  describe(reader);
  reader.section(section, "");
  for (const char* key : {"driver", "process_rate", "max_queue_len", "sensorLabel",
                          "grab_decimation", "rawlog-grabber-ignore"}) {
    std::string read_by_mrpt;
    reader.value(key, read_by_mrpt, "");
  }
  for (const std::string& key : acquisitionKeys()) {
    std::string read_by_acquisition;
    if (settings.find(section, key) != nullptr) reader.value(key.c_str(), read_by_acquisition, "");
  }
  reader.finish();
}

}  // namespace vir::roles
