#pragma once
/// The transform to one other robot's world, kept up to date while both run.
#include <optional>
#include <vector>

#include "vir/team/find_transform.h"

namespace vir::team {

struct TransformTrackerOptions {
  TransformOptions transform;
  int max_ranges = 1000;  ///< kept at once; beyond, every second of the older half goes

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Rendezvous].
void describe(OptionVisitor& v, TransformTrackerOptions& o);

class TransformTracker {
 public:
  /// Throws as TransformTrackerOptions::validate().
  explicit TransformTracker(const TransformTrackerOptions& options = {});

  /// A range with the segments of both robots' worlds (they count up when an estimator starts
  /// anew). A new segment is a new world: what was known of the old one is dropped. Ranges of older
  /// segments are left out.
  void add(const MutualRange& range, int segment_A = 0, int segment_B = 0);
  /// All anchors that both know, as believed now; replaces what was set before.
  void setAnchors(const std::vector<SharedAnchor>& anchors) { anchors_ = anchors; }
  /// What both have seen, as known now; replaces what was set before. Of other segments than those
  /// of the newest range it says nothing.
  void setPlaces(const std::optional<SharedPlaces>& places) { places_ = places; }
  /// A's poses go on in another frame, to which `T_new_A` takes all that is known.
  void moveA(const WorldTransform& T_new_A);
  /// A sequential test decides when the evidence first suffices: what was `unique` stays so, also
  /// when the margin falls again or the standard deviations rise (they are told), until another
  /// solution is the best one, the ranges fit none or a new world begins.
  TransformAnswer answer();

  std::size_t kept() const { return ranges_.size(); }
  long seen() const { return seen_; }  ///< ranges of the present segments
  int restarts() const { return restarts_; }

 private:
  bool stillDecided(const TransformAnswer& answer) const;
  std::optional<SharedPlaces> placesNow() const;

  TransformTrackerOptions options_;
  std::vector<MutualRange> ranges_;
  std::vector<SharedAnchor> anchors_;
  std::optional<SharedPlaces> places_;
  std::vector<WorldTransform> hints_;
  struct Decided {
    WorldTransform T;
    Eigen::Matrix4d covariance;  ///< (yaw, x, y, z)
    bool height_open;
  };
  std::optional<Decided> decided_;  ///< as last answered
  int segment_A_ = 0, segment_B_ = 0, restarts_ = 0;
  long seen_ = 0;
};

}  // namespace vir::team
