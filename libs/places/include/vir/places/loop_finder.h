#pragma once
/// From keyframes to loops that may be believed: candidates by appearance, verified, refused where
/// another place fits as well, and accepted when consecutive keyframes agree.
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/options.h"
#include "vir/places/describer.h"
#include "vir/places/place_index.h"
#include "vir/places/verify_loop.h"

namespace vir::places {

struct LoopFinderOptions {
  double recent_s = 15;        ///< younger keyframes are no second visit
  int neighbours = 1;          ///< before and after a candidate that lend it their points
  int neighbours_unknown = 3;  ///< the same where no prior says to `known_sigma_m` where it is
  int agreeing = 2;            ///< keyframes that must agree, the newest included
  int agreeing_unknown = 3;    ///< the same where no prior says to `known_sigma_m` where it is
  double agree_s = 5;          ///< within this long
  double agree_move_m = 0.1;   ///< and taken from places so far apart: one look twice is one look
  double agree_chi2 = 28;      ///< of six degrees of freedom
  double path_share = 0.02;    ///< drift of the path within `agree_s` and between near keyframes
  double ambiguous = 0.6;      ///< another place with this share of the best one's inliers
  double outstanding = 0.3;  ///< too few corners may do where none elsewhere has this share of them
  /// Where no prior says to `known_sigma_m` where it is: of what must be in view, the images of
  /// those that agree show so much. Corners of a place that looks the same fit, but not what is
  /// between.
  double min_alike = 0.65;
  double apart_m = 1.0;    ///< is another place if it is this far away
  double apart_rad = 0.3;  ///< or turned by this much

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
void describe(OptionVisitor& v, LoopFinderOptions& o);

/// A candidate and what became of it, for loops.csv.
struct LoopAttempt {
  std::uint64_t older = 0, newer = 0;
  double score = 0;  ///< of the appearance
  LoopVerdict verdict;
  /// "accepted", or why not: name(LoopRefusal), "ambiguous", "waits for another", "unlike".
  std::string decision;
};

class LoopFinder {
 public:
  /// What odometry and ranges say of two keyframes; nothing if nothing is known.
  using Prior = std::function<std::optional<RelativePrior>(const PlaceKeyframe& older,
                                                           const PlaceKeyframe& newer)>;

  /// See Describer::compare(), of the newer keyframe's image.
  using Compare = std::function<std::vector<int>(const std::vector<ExpectedPoint>& expected)>;

  LoopFinder(const LoopFinderOptions& options, const PlaceIndexOptions& index,
             const VerifyOptions& verify);

  /// Looks for the place of `keyframe` among those remembered, then remembers it. Returns the loops
  /// that became believed by it (also of the keyframes just before that waited for it), oldest
  /// first. Places that `allowed` rules out are not looked at. Without `compare` the corners alone
  /// must tell one place from another. Ids must rise.
  std::vector<Loop> add(std::shared_ptr<const PlaceKeyframe> keyframe, const Prior& prior = {},
                        const PlaceIndex::Allowed& allowed = {}, const Compare& compare = {});
  /// Remembers without looking: a map that was loaded.
  void remember(std::shared_ptr<const PlaceKeyframe> keyframe);

  /// Of the last add().
  const std::vector<LoopAttempt>& attempts() const { return attempts_; }
  const PlaceIndex& index() const { return index_; }

 private:
  /// A loop that may be believed, if another one agrees.
  struct Opinion {
    Loop loop;
    double chi2 = 0;       ///< against the prior
    bool known = false;    ///< the prior says where the place must be
    bool allowed = false;  ///< by the prior, with corners enough
    bool weak = false;     ///< by the prior, with too few to be believed as it is
    std::shared_ptr<const PlaceKeyframe> older, newer;
    bool told = false;
    bool compared = false;  ///< the image was: `in_view` and `alike` say how it fits
    int in_view = 0, alike = 0;
  };
  std::vector<Opinion> look(const std::shared_ptr<const PlaceKeyframe>& keyframe,
                            const Prior& prior, const PlaceIndex::Allowed& allowed, bool compares);
  bool hasCorners(const LoopVerdict& verdict, bool compares) const;
  std::optional<std::size_t> choose(const std::vector<Opinion>& found) const;
  bool unique(const std::vector<Opinion>& found, std::size_t chosen, const Prior& prior) const;
  bool outstanding(const LoopAttempt& best, const Prior& prior) const;
  std::vector<Loop> confirm(Opinion opinion, const Prior& prior);
  std::optional<RelativePrior> between(const PlaceKeyframe& a, const PlaceKeyframe& b,
                                       const Prior& prior) const;
  bool samePlace(const Opinion& a, const Opinion& b, const Prior& prior) const;
  bool agree(const Opinion& a, const Opinion& b, const Prior& prior) const;
  bool enough(const Opinion& now, const std::vector<Opinion*>& agreeing) const;
  bool alike(const Opinion& now, const std::vector<Opinion*>& agreeing) const;
  void decide(const Opinion& opinion, const char* decision);

  LoopFinderOptions options_;
  VerifyOptions verify_;
  PlaceIndex index_;
  std::deque<std::pair<std::uint64_t, TimeNs>> recent_;  ///< added, not loaded
  std::vector<Opinion> waiting_;
  std::vector<LoopAttempt> attempts_;
};

}  // namespace vir::places
