#include "range_streams.h"

#include <filesystem>
#include <set>

#include "lever_arms.h"
#include "stream_setup.h"
#include "vir/rawlog/labels.h"
#include "vir/tables/ranges.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

class Opener {
 public:
  Opener(const std::vector<RangeFiles>& files, const EurocOptions& o, const Pose& T_B_I,
         tables::AnchorNames* names, ProblemLog* log, ProblemLog* silent)
      : files_(files), o_(o), T_B_I_(T_B_I), names_(names), log_(log), silent_(silent) {}

  std::vector<RangeStream> open() {
    checkLeverArms(o_.lever_arm_m);
    for (const RangeFiles& f : files_) labels_.insert(labelOf(f.name, rawlog::kRangeLabel));
    for (const RangeFiles& f : files_) {
      f.between_anchors ? addBetweenAnchors(f) : add(f);
    }
    return std::move(streams_);
  }

 private:
  std::string freeLabel() {
    for (int n = 1;; ++n) {
      const std::string label = rawlog::furtherLabel(rawlog::kRangeLabel, std::to_string(n));
      if (labels_.insert(label).second) return label;
    }
  }

  void addBetweenAnchors(const RangeFiles& files) {
    RangeStream s;
    s.rows = openAnchorRanges(files.file, unitsOf(o_), names_, log_);
    streams_.push_back(std::move(s));
  }

  void add(const RangeFiles& files) {
    const tables::RangeColumns columns = tables::rangeColumns(tables::layoutOf(files.file));
    RangeStream s;
    s.label = labelOf(files.name, rawlog::kRangeLabel);
    s.sigma_m = o_.range_sigma_m;
    const bool by_settings = saysSeveral(o_.lever_arm_m) || files.yaml.empty();
    Vec3 antenna = Vec3::Zero();
    if (!files.yaml.empty()) {
      const UwbYaml uwb = readUwbYaml(files.yaml);
      antenna = T_B_I_.inverse() * uwb.T_B_U.p;
      s.sigma_m = uwb.sigma_m.value_or(o_.range_sigma_m);
    }
    sayUnsaid(files, columns);
    if (columns.hasLever() && saysSeveral(o_.lever_arm_m)) {
      log_->note(files.file + ": the places of its columns are not used, lever_arm_m says several");
    }
    std::vector<std::string> antennas = antennasIn(files.file);
    const bool split = o_.antenna.empty() && antennas.size() > 1;
    if (!split) antennas = {o_.antenna};
    std::string said;
    for (const std::string& name : antennas) {
      RangeStream each;
      const bool first = &name == &antennas.front();
      each.label = first ? s.label : freeLabel();
      each.only = name;
      each.sigma_m = s.sigma_m;
      if (split) each.known = {antennas.begin(), antennas.end()};
      each.tells = first;
      each.antenna = by_settings ? leverArm(o_.lever_arm_m, streams_.size()) : antenna;
      each.by_settings = saysSeveral(o_.lever_arm_m);
      each.rows = openRanges(files.file, unitsOf(o_), names_, first ? log_ : silent_);
      skipOtherAntennas(&each, log_);
      said += (said.empty() ? "" : ", ") + name + " is " + each.label;
      streams_.push_back(std::move(each));
    }
    if (split) note(files, antennas.size(), columns.hasLever(), said);
  }

  /// What a table without a calibration leaves to the settings.
  void sayUnsaid(const RangeFiles& files, const tables::RangeColumns& c) {
    if (!files.yaml.empty() || (c.hasLever() && c.sigma >= 0)) return;
    const bool neither = !c.hasLever() && c.sigma < 0;
    const std::string what = neither       ? "neither antenna nor noise"
                             : c.sigma < 0 ? "no noise"
                                           : "no antenna";
    const std::string used = neither ? "lever_arm_m and range_sigma_m of the settings are used"
                             : c.sigma < 0 ? "range_sigma_m of the settings is used"
                                           : "lever_arm_m of the settings is used";
    log_->note((o_.section == "csv"
                    ? files.file + ": tells " + what
                    : fs::path(files.file).parent_path().string() + "/sensor.yaml: missing") +
               "; " + used);
  }

  void note(const RangeFiles& files, std::size_t antennas, bool by_columns,
            const std::string& said) {
    const bool placed = by_columns || o_.lever_arm_m.size() >= 3 * streams_.size();
    log_->note(files.file + ": ranges of " + std::to_string(antennas) + " antennas (" + said + ")" +
               (placed ? ""
                       : ", of which only one position is known, which all have in the rawlog: "
                         "lever_arm_m = x y z of UWB0, UWB1, ... one behind the other gives each "
                         "its own; a run takes UWB0 alone unless range_label names more"));
  }

  const std::vector<RangeFiles>& files_;
  const EurocOptions& o_;
  const Pose T_B_I_;
  tables::AnchorNames* names_;
  ProblemLog* log_;
  ProblemLog* silent_;
  std::set<std::string> labels_;
  std::vector<RangeStream> streams_;
};

}  // namespace

std::vector<RangeStream> openRangeFiles(const std::vector<RangeFiles>& files, const EurocOptions& o,
                                        const Pose& T_B_I, tables::AnchorNames* names,
                                        ProblemLog* log, ProblemLog* silent) {
  return Opener(files, o, T_B_I, names, log, silent).open();
}

void skipOtherAntennas(RangeStream* s, ProblemLog* log) {
  if (s->only.empty()) return;
  while (s->rows->peek() != nullptr && s->rows->peek()->antenna != s->only) {
    // Those of a label of their own are not lost.
    if (s->tells && s->known.count(s->rows->peek()->antenna) == 0) {
      log->count("range_of_another_antenna");
    }
    s->rows->pop();
  }
}

}  // namespace vir::euroc
