#pragma once
/// What a benchmark consists of: recordings (real, or simulated under several conditions and seeds)
/// and the settings that each of them is run with.
#include <string>
#include <utility>
#include <vector>

#include "vir/core/settings.h"

namespace vir::app {

/// `Section.key` and value, as for --set.
using Assignments = std::vector<std::pair<std::string, std::string>>;

/// Section [Sequence_NAME]: a rawlog, or a world to simulate; further keys `Section.key` go to
/// `vir-slam simulate`.
struct BatchSequence {
  std::string name;
  std::string rawlog;  ///< of a recording that exists
  std::string world;   ///< ini of the simulator
  std::vector<std::string> conditions;
  std::vector<int> seeds;  ///< of a simulated one
  std::string note;        ///< goes into the table
  Assignments set;
};

/// Section [Condition_NAME]: what makes a simulated sequence easier or harder.
struct BatchCondition {
  std::string name;
  Assignments set;
};

/// Section [Setting_NAME]: how recordings are run; further keys go to `vir-slam run`.
struct BatchSetting {
  std::string name;
  std::string ini;
  std::string title;  ///< in the table; empty = the name
  Assignments set;
};

struct BatchPlan {
  std::string file;             ///< the ini it was read from
  double timeout_s = 3600;      ///< of one recording or run; longer counts as failed
  bool keep_recordings = true;  ///< simulated ones, after their last run
  std::vector<BatchSequence> sequences;
  std::vector<BatchCondition> conditions;
  std::vector<BatchSetting> settings;
};

/// Reads and checks a benchmark's ini. Paths in it are relative to it; `extra` are assignments from
/// the command line. Throws SettingsError.
BatchPlan readBatchPlan(const std::string& file, const std::vector<std::string>& extra);

/// One recording of the plan.
struct BatchRecording {
  const BatchSequence* sequence = nullptr;
  const BatchCondition* condition = nullptr;  ///< null: a rawlog that exists
  int seed = 0;
  /// `sequence` or `sequence-condition-seed`: also its name in the results folder.
  std::string name() const;
  /// `sequence` or `sequence-condition`: a row of the table.
  std::string row() const;
};

/// In the order of the ini.
std::vector<BatchRecording> recordingsOf(const BatchPlan& plan);

}  // namespace vir::app
