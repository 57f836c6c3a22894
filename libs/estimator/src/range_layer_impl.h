#pragma once
/// Internal: ranges on their way in (range_layer.cpp) and the anchors' lives (anchor_life.cpp).
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "anchor_distances.h"
#include "anchor_track.h"
#include "elapsed.h"
#include "survey_life.h"
#include "vir/estimator/range_layer.h"
#include "vir/ranging/range_check.h"

namespace vir::estimator {

/// A prior narrower than this leaves nothing for a solver in double precision to weigh [m].
constexpr double kLeastPriorSigma = 1e-4;

/// An anchor has settled once a fresh search knows it so well [m].
constexpr double kSettledSigma = 0.3;

/// There is a position, though perhaps its mirror image as well.
inline bool isUsable(const ranging::AnchorInitialization& found) {
  return !found.solutions.empty() && (found.geometry == ranging::AnchorGeometry::good ||
                                      found.geometry == ranging::AnchorGeometry::mirror);
}

/// Reference and anchor of a difference.
using AnchorPair = std::pair<std::uint64_t, std::uint64_t>;

/// What is known of the differences of ranges to two anchors.
struct DifferenceTrack {
  ranging::RangeGate gate;
  long used = 0, rejected = 0, collected = 0;
  long heard() const { return used + rejected + collected; }
};

struct RangeLayer::Impl {
  Impl(const RangeOptions& o, window::LongWindow* w, LogSink l)
      : options(o), window(w), log_sink(std::move(l)) {
    for (std::size_t i = 0; i + 4 < o.anchor_prior.size(); i += 5) {
      const double* v = &o.anchor_prior[i];
      setPrior(static_cast<std::uint64_t>(v[0]), Vec3(v[1], v[2], v[3]), v[4]);
    }
    survey.given = o.survey;
  }
  static ranging::RangeCheckOptions checkOptions(const RangeOptions& o) {
    ranging::RangeCheckOptions c;
    c.max_range_m = o.max_range_m;
    return c;
  }

  ranging::GateOptions gateOptions() const;
  AnchorTrack& track(std::uint64_t id);
  void travelTo(const Vec3& antenna_W);
  void setPrior(std::uint64_t id, const Vec3& p_W, double sigma_m);
  /// Without a decision yet; the second with what was predicted.
  static RangeRecord recordOf(const Range& r);
  static RangeRecord recordOf(const Range& r, double residual_m, double variance);
  void record(const Range& r, RangeDecision decision);
  double sigmaOf(const Range& r) const {
    return r.sigma_m > 0 ? r.sigma_m * options.sigma_scale : options.sigma_m;
  }
  /// Measured - predicted [m], and its variance, the prediction's included [m^2].
  struct Innovation {
    double residual = 0, variance = 0;
  };
  Innovation innovation(const AnchorTrack& a, const window::AnchorNode& state,
                        const AntennaPrediction& antenna, const window::HeldRange& held) const;
  /// An anchor that was given up may have been right all the time, behind something: when its
  /// ranges agree with its former position again, that is taken up again.
  bool returnIfFormerFits(TimeNs t, AnchorTrack* a);
  void compareWithFormer(AnchorTrack* a, const AntennaPrediction& antenna,
                         const window::HeldRange& held);
  /// `uncalibrated`: with the bias such a board may have.
  ranging::AnchorInitialization solve(const AnchorTrack& a,
                                      const std::vector<window::HeldRange>& held,
                                      bool uncalibrated) const;
  /// The same either way, whichever the ranges ask for; `a->uncalibrated` follows.
  ranging::AnchorInitialization solveEitherWay(AnchorTrack* a,
                                               const std::vector<window::HeldRange>& held) const;
  double biasSigma(bool uncalibrated) const {
    return uncalibrated ? std::max(options.uncalibrated_bias_sigma_m, options.bias_sigma_m)
                        : options.bias_sigma_m;
  }
  bool mayBeUncalibrated() const { return biasSigma(true) > biasSigma(false); }
  void searchForBias(const AnchorTrack& a, Located* located, const Held& held) const;
  void reconsider(TimeNs t, AnchorTrack* a, window::AnchorNode* state);
  bool decideBias(TimeNs t, AnchorTrack* a, Located* located, const Held& held);
  bool tryToFind(TimeNs t, AnchorTrack* a, Collecting* collecting, const Held& held);
  void adopt(TimeNs t, AnchorTrack* a, const ranging::AnchorInitialization& found);
  bool decideMirror(TimeNs t, AnchorTrack* a, Located* located, const Held& held,
                    const std::vector<window::HeldRange>& head);
  bool searchAgain(TimeNs t, AnchorTrack* a, Located* located, const Held& held,
                   const std::vector<window::HeldRange>& head);
  void moveTo(TimeNs t, AnchorTrack* a, Located* located, const Vec3& p_W);
  void endYouth(const AnchorTrack& a, Located* located);
  /// It has explained its ranges for so long that it was moved if it does so no more.
  static bool trusted(const AnchorTrack& a, bool well_known);
  void giveUp(TimeNs t, AnchorTrack* a, bool trusted);
  bool giveUpIfElsewhere(TimeNs t, AnchorTrack* a, const Located& located);
  void reweigh(AnchorTrack* a, const Held& held);
  /// What would make it better known, in words and as a place to go to; nothing where it is known
  /// well enough (anchor_advice.cpp).
  void advise(const AnchorTrack& track, Anchor* anchor) const;
  // survey_life.cpp
  /// Finds how the survey lies in W, holds its anchors to it, and notices what is wrong with it.
  /// True if the anchors changed.
  bool updateSurvey(TimeNs t, const Held& held, const HeldDifferences& differences);
  bool isSurveyed(std::uint64_t id) const;
  /// All ranges held to an anchor, those that were not believed too where it is surveyed.
  std::vector<window::HeldRange> allHeld(const AnchorTrack& a, const Held& held) const;
  void untie(TimeNs t, AnchorTrack* a);
  std::vector<ranging::SurveyRange> surveyRanges(const Held& held) const;
  ranging::SurveyMatch matchAgain(std::vector<ranging::SurveyRange> ranges,
                                  const ranging::SurveyMatchOptions& o) const;
  void takeMatch(TimeNs t, ranging::SurveyMatch match);
  void tie(TimeNs t, AnchorTrack* a, const ranging::MatchedAnchor& m, const SurveyedAnchor& given);
  void setTies();
  /// What anchors have measured to one another, with what is known of their biases by now.
  void setDistances();
  bool placeNewlyHeard(TimeNs t);
  // range_differences.cpp
  RangeDecision checkDifference(const Range& range);
  bool acceptDifference(const Range& range, const AntennaPrediction& antenna,
                        window::HeldRange* held);
  Innovation differenceInnovation(const window::HeldRange& held,
                                  const AntennaPrediction& antenna) const;
  bool updateSurveyByDifferences(TimeNs t, const HeldDifferences& differences);
  void warnOfDifferencesWithoutPlaces();
  void addSurveyed(const std::vector<Anchor>& anchors, SurveyFit* out) const;  // survey_result.cpp
  void warn(const std::string& text) {
    log(log_sink, LogLevel::warning, text);
    warnings.push_back(text);
  }

  RangeOptions options;
  window::LongWindow* window;
  Elapsed elapsed;
  LogSink log_sink;
  /// Antennas of the robot, by where they are on it: each has a stream of its own to every anchor.
  struct Antenna {
    Vec3 p_B_U = Vec3::Zero();
    ranging::RangeCheck check;
    std::map<AnchorPair, ranging::RangeCheck> of_differences;
  };
  Antenna& antennaAt(const Vec3& p_B_U);
  std::vector<Antenna> antennas;
  std::map<std::uint64_t, AnchorTrack> tracks;
  std::vector<Range> pending;  ///< ordered by time
  std::map<AnchorPair, DifferenceTrack> differences;
  bool differences_warned = false;
  SurveyLife survey;
  AnchorDistances distances;
  long anchor_ranges_unusable = 0;  ///< between anchors, that cannot be
  std::vector<RangeRecord> decisions;
  std::vector<std::string> warnings;
  long found_anew = 0;         ///< anchors given up and looked for again
  long taken_up_again = 0;     ///< of those, where they had been
  long put_down_unseen = 0;    ///< anchors put down when there was no pose
  long put_down_unusable = 0;  ///< or with a place, sigma or id that cannot be
  double travelled_m = 0;
  Vec3 last_antenna = Vec3::Zero();
  bool any_antenna = false;
  double lowest_antenna_m = std::numeric_limits<double>::infinity();  ///< it has been in W
  int keyframes = 0;
  bool spreads_work = false;  ///< somebody calls between keyframes
};

}  // namespace vir::estimator
