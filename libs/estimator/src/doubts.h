#pragma once
/// Internal: what speaks against the states that the windows give.
#include <map>
#include <string>
#include <vector>

#include "elapsed.h"
#include "vir/types/state.h"

namespace vir::estimator {

/// What one image says beside its state.
struct Evidence {
  bool full = false;    ///< the whole window was solved: its residuals count
  bool blind = false;   ///< nothing but readings held the state
  double acc_gain = 0;  ///< how far it is from what was given, in sigmas of its prior
};

/// Watches levels over about a second, each against what good recordings show and with room above
/// (docs/decisions.md). Kinds of doubt are told once, with the time they first held.
class Doubts {
 public:
  /// The first image: times are told since then.
  void begin(TimeNs t) { elapsed_.begin(t); }
  /// A state in order of time; what follows from it is in current().
  void look(const StateEstimate& estimate, const Evidence& evidence);
  /// The windows were given up.
  void restarted(TimeNs t, const std::string& why);
  /// Something found outside, for example of the calibration; once per kind.
  void add(const std::string& kind, TimeNs t, const std::string& text);
  /// What explains the others: told before them.
  void addCause(const std::string& kind, TimeNs t, const std::string& text);
  /// What speaks against the newest state; empty: nothing.
  const std::string& current() const { return current_; }
  /// What the variances of the newest state are to be multiplied with while it is in doubt: by how
  /// much the levels are above those of good recordings, and not less than 4 (twice the standard
  /// deviation); 1 without a doubt.
  double inflation() const;
  /// All kinds of the run, in the order they came.
  std::vector<std::string> all() const;

 private:
  struct Level {
    double value = 0;
    int count = 0;
    void add(double x, double share) { value = count++ == 0 ? x : value + share * (x - value); }
  };
  /// `made` says it in words; asked only where `bad`.
  template <typename Text>
  void raiseIf(bool bad, TimeNs t, const char* kind, const Text& made);
  void lookAtCalibration(const StateEstimate& estimate, double acc_gain);
  void compareVelocity(const StateEstimate& estimate);
  Level inertial_, reprojection_, seen_;
  State before_;                      // of the last image; t = 0: none
  Vec3 against_path_ = Vec3::Zero();  // mean velocity beside that of the positions [m/s]
  int compared_ = 0;                  // images in it
  TimeNs blind_since_ = 0;            // 0: nothing was looked at yet
  Elapsed elapsed_;
  std::map<std::string, std::size_t> known_;
  std::vector<std::string> texts_;
  std::string current_;
};

}  // namespace vir::estimator
