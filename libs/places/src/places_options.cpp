#include "vir/core/option_check.h"
#include "vir/places/describer.h"
#include "vir/places/loop_finder.h"
#include "vir/places/place_index.h"
#include "vir/places/verify_loop.h"

namespace vir::places {

void describe(OptionVisitor& v, DescriberOptions& o) {
  v.section("Places", "What is remembered of a keyframe's image");
  v.value("points", o.points, {20, 1000}, "corners described, landmarks first");
  v.value("min_distance_px", o.min_distance_px, {3.0, 100.0},
          "distance of a further corner to others");
  v.value("min_corner_score", o.min_corner_score, {0.0, 1e6},
          "smaller eigenvalue of the mean gradient tensor [(grey levels/pixel)^2] a corner needs");
}

void DescriberOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, PlaceIndexOptions& o) {
  v.section("PlaceIndex", "Which keyframes look like this one");
  v.value("max_keyframes", o.max_keyframes, {10, 1000000},
          "remembered; beyond, those go that are seen twice anyway");
  v.value("candidates", o.candidates, {1, 100}, "places that are looked at, of one keyframe");
  v.value("group_s", o.group_s, {0.0, 60.0}, "keyframes within this long are one place");
  v.value("min_votes", o.min_votes, {1, 1000}, "agreeing descriptors a candidate needs");
  v.value("max_distance_bits", o.max_distance_bits, {1, 128},
          "descriptors that differ in more do not agree");
}

void PlaceIndexOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, VerifyOptions& o) {
  v.section("LoopCheck", "Is it the same place, and where are the two keyframes?");
  v.value("sigma_px", o.sigma_px, {0.01, 100.0}, "of a corner that is found again");
  v.value("sigma_px_unknown", o.sigma_px_unknown, {0.01, 100.0},
          "the same where nothing says how the two lie to each other, as in a map");
  v.value("focal_px", o.focal_px, {0.0, 1e5},
          "pixels per radian that sigma_px is meant for; 0 = as the image says");
  v.value("max_distance_bits", o.max_distance_bits, {1, 128}, "of descriptors that are matched");
  v.value("ratio", o.ratio, {0.1, 1.0}, "distance of the best to that of the second best");
  v.value("max_iterations", o.max_iterations, {10, 100000}, "of the random search for a pose");
  v.value("min_matches", o.min_matches, {4, 1000}, "fewer are not looked at");
  v.value("min_inliers", o.min_inliers, {6, 1000}, "corners that fit the pose");
  v.value("min_inliers_known", o.min_inliers_known, {6, 1000},
          "the same where odometry and ranges say as well where the place must be");
  v.value("min_share", o.min_share, {0.0, 1.0}, "of the points in view that are found again");
  v.value(
      "min_inliers_alone", o.min_inliers_alone, {4, 1000},
      "corners with which a place counts that nothing else looks like, if more keyframes agree");
  v.value("min_share_alone", o.min_share_alone, {0.0, 1.0}, "the same as a share");
  v.value("min_inliers_compared", o.min_inliers_compared, {4, 1000},
          "the same where the image is compared with what it must show, as in a map");
  v.value("min_share_compared", o.min_share_compared, {0.0, 1.0}, "likewise");
  v.value("sure_share", o.sure_share, {0.0, 1.0}, "of so many, min_inliers_known are enough");
  v.value("min_share_known", o.min_share_known, {0.0, 1.0},
          "the same where odometry and ranges say as well where the place must be");
  v.value("known_sigma_m", o.known_sigma_m, {0.0, 1000.0},
          "odometry and ranges that are less certain do not say it");
  v.value("min_spread_rad", o.min_spread_rad, {0.0, 1.0}, "of the fitting corners' rays");
  v.value("max_sigma_m", o.max_sigma_m, {0.001, 100.0}, "a pose less certain is no loop");
  v.value("max_sigma_rad", o.max_sigma_rad, {0.0001, 3.0}, "a pose less certain is no loop");
  v.value("gravity_sigma_rad", o.gravity_sigma_rad, {1e-5, 1.0}, "of a keyframe's roll and pitch");
  v.value("scale_sigma", o.scale_sigma, {0.0, 1.0},
          "of a keyframe's distances, all together (relative)");
  v.value("bias_px", o.bias_px, {0.0, 100.0},
          "of lens and distances, all corners together: more corners do not help");
  v.value("prior_chi2", o.prior_chi2, {1.0, 1e6},
          "squared distance to odometry and ranges, of six degrees of freedom");
  v.value("seed", o.seed, {0, 2000000000}, "of the random search");
}

void VerifyOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, LoopFinderOptions& o) {
  v.section("Loops", "Second visits that may be believed");
  v.value("recent_s", o.recent_s, {0.0, 1e5}, "younger keyframes are no second visit");
  v.value("neighbours", o.neighbours, {0, 10},
          "before and after a place that lend it their points");
  v.value("neighbours_unknown", o.neighbours_unknown, {0, 10},
          "the same where neither odometry nor ranges say where the place is");
  v.value("agreeing", o.agreeing, {1, 10}, "keyframes that must agree");
  v.value("agreeing_unknown", o.agreeing_unknown, {1, 10},
          "the same where neither odometry nor ranges say where the place is");
  v.value("agree_s", o.agree_s, {0.0, 600.0}, "within this long");
  v.value("agree_move_m", o.agree_move_m, {0.0, 100.0}, "and taken from places so far apart");
  v.value("path_share", o.path_share, {0.0, 1.0}, "drift of the path over a few seconds");
  v.value("agree_chi2", o.agree_chi2, {1.0, 1e6}, "squared distance, of six degrees of freedom");
  v.value("ambiguous", o.ambiguous, {0.0, 1.0},
          "another place with this share of the best one's corners makes it doubtful");
  v.value("outstanding", o.outstanding, {0.0, 1.0},
          "corners too few may do where no place elsewhere has this share of them");
  v.value(
      "min_alike", o.min_alike, {0.0, 1.0},
      "of what an image must show it shows so much, where neither odometry nor ranges say where "
      "the place is");
  v.value("apart_m", o.apart_m, {0.0, 1000.0}, "another place is this far away");
  v.value("apart_rad", o.apart_rad, {0.0, 3.2}, "or turned by this much");
}

void LoopFinderOptions::validate() const { checkBounds(*this); }

}  // namespace vir::places
