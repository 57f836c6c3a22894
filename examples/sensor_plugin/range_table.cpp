/// Ranges to anchors from a table: lines "t_s,anchor,range_m" in time order, # begins a comment.
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/roles/grabber_settings.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"

namespace example {

class RangeTable : public mrpt::hwdrivers::CGenericSensor, public vir::roles::RecordedSource {
  DEFINE_GENERIC_SENSOR(RangeTable)

 public:
  RangeTable() { m_sensorLabel = vir::rawlog::kRangeLabel; }

  void describe(vir::OptionVisitor& v) override {
    v.section("range_table", "Ranges to anchors from a table t_s,anchor,range_m");
    v.value("source", file_, "the table");
    v.value("sigma_m", sigma_m_, {1e-3, 10}, "standard deviation of a range");
  }
  void initialize() override {
    table_.open(file_);
    if (!table_) throw std::runtime_error("range_table: cannot read " + file_);
    m_state = ssWorking;
  }
  void doProcess() override {
    std::string line;
    if (!std::getline(table_, line)) {
      finished_ = true;
      return;
    }
    ++lines_;
    if (line.empty() || line[0] == '#') return;
    double t_s = 0;
    unsigned anchor = 0;
    vir::Range range;
    if (std::sscanf(line.c_str(), "%lf,%u,%lf", &t_s, &anchor, &range.range_m) != 3 ||
        range.range_m <= 0) {
      ++bad_;
      return;
    }
    range.t = vir::fromSeconds(t_s);
    range.anchor = anchor;
    range.sigma_m = sigma_m_;
    appendObservation(vir::rawlog::toObservation(range, m_sensorLabel));
    ++ranges_;
  }

  double progress() const override { return finished_ ? 1 : 0; }
  bool finished() const override { return finished_; }
  std::vector<std::pair<std::string, long>> counters() const override {
    return {{"ranges", ranges_}, {"lines_unreadable", bad_}};
  }
  std::vector<std::string> warnings() const override {
    if (bad_ == 0) return {};
    return {file_ + ": " + std::to_string(bad_) + " of " + std::to_string(lines_) +
            " lines are not t_s,anchor,range_m with a range above 0"};
  }

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override {
    vir::roles::readGrabberSection(config, section, [this](vir::OptionVisitor& v) { describe(v); });
  }

 private:
  std::string file_;
  double sigma_m_ = 0.1;
  std::ifstream table_;
  long lines_ = 0, ranges_ = 0, bad_ = 0;
  bool finished_ = false;
};

}  // namespace example

IMPLEMENTS_GENERIC_SENSOR(RangeTable, example)

namespace example {
VIR_REGISTER_SENSOR(RangeTable, "range_table", "ranges to anchors from a table");
}
