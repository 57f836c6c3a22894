#pragma once
/// Pairs of images: MRPT's CObservationStereoImages and one image with both views side by side are
/// taken apart into images of their own, and put together again.
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImages.h>

#include <utility>
#include <vector>

#include "vir/rawlog/pair_names.h"

namespace vir::rawlog {

/// The left image, and the right one if there is one, with stamp, lens and place in the body
/// [m]. Pixels are shared, not copied. Throws std::invalid_argument if a place is no pose.
std::vector<mrpt::obs::CObservationImage::Ptr> imagesOf(
    const mrpt::obs::CObservationStereoImages& pair, const PairLabels& labels);

/// The pair of two images of one instant, under the label of the left one and with its stamp; the
/// right one's place relative to it. Pixels are shared.
mrpt::obs::CObservationStereoImages::Ptr pairOf(const mrpt::obs::CObservationImage& left,
                                                const mrpt::obs::CObservationImage& right);

/// The left and the right half of an image that holds two views side by side; lens and place of
/// both are those of `wide`. Throws std::invalid_argument if its width is odd or it has no pixels.
std::vector<mrpt::obs::CObservationImage::Ptr> halvesOf(const mrpt::obs::CObservationImage& wide,
                                                        const PairLabels& labels);

/// Puts together the images of two labels that have one stamp; everything else goes through. The
/// order of time stays.
class PairJoiner {
 public:
  explicit PairJoiner(PairLabels labels) : labels_(std::move(labels)) {}
  /// Observations in the order of time, and what can go on: an image waits until its stamp is past.
  std::vector<mrpt::obs::CObservation::Ptr> add(const mrpt::obs::CObservation::Ptr& observation);
  /// What still waits.
  std::vector<mrpt::obs::CObservation::Ptr> finish();
  long pairs() const { return pairs_; }
  /// Images of the two labels without a partner.
  long single() const { return single_; }

 private:
  void join();

  PairLabels labels_;
  std::vector<mrpt::obs::CObservation::Ptr> waiting_;  // of one stamp
  long pairs_ = 0, single_ = 0;
};

}  // namespace vir::rawlog
