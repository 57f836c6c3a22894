#include "vir/rawlog/stereo_images.h"

#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DQuat.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "vir/core/parse_number.h"
#include "vir/rawlog/labels.h"

namespace vir::rawlog {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservationImage;
using mrpt::obs::CObservationStereoImages;
using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DQuat;

std::string cameraLabel(std::size_t k) { return furtherLabel(kCameraLabel, std::to_string(k)); }

/// MRPT makes anything of a quaternion that is none.
CPose3D poseOf(const CPose3DQuat& T, const char* whose) {
  double square = 0;
  for (unsigned k = 0; k < 7; ++k) {
    if (!std::isfinite(T[k])) square = -1;
    if (k >= 3 && square >= 0) square += T[k] * T[k];
  }
  if (!(std::abs(square - 1) < 1e-3)) {
    throw std::invalid_argument(std::string("the place of the ") + whose +
                                " camera of a pair is no pose");
  }
  return CPose3D(T);
}

CPose3DQuat quatOf(const CPose3D& T) {
  mrpt::math::CQuaternionDouble q;
  T.getAsQuaternion(q);
  return {T.x(), T.y(), T.z(), q};
}

CObservationImage::Ptr imageLike(const CObservation& of, const std::string& label) {
  auto image = std::make_shared<CObservationImage>();
  image->timestamp = of.timestamp;
  image->sensorLabel = label;
  return image;
}

}  // namespace

PairLabels PairNames::of(const std::string& pair_label) {
  const auto known = known_.find(pair_label);
  if (known != known_.end()) return known->second;
  std::uint32_t n = 0;
  const std::size_t digits = furtherLabel(kCameraLabel, "").size();
  const bool camera = pair_label.compare(0, digits, cameraLabel(0), 0, digits) == 0 &&
                      parseNumber(std::string_view(pair_label).substr(digits), &n);
  PairLabels labels{cameraLabel(2 * given_), cameraLabel(2 * given_ + 1)};
  if (camera) labels = {pair_label, cameraLabel(std::size_t{n} + 1)};
  ++given_;
  return known_[pair_label] = labels;
}

std::vector<CObservationImage::Ptr> imagesOf(const CObservationStereoImages& pair,
                                             const PairLabels& labels) {
  const CPose3D T_B_L = poseOf(pair.cameraPose, "left");
  auto left = imageLike(pair, labels.left);
  left->image = pair.imageLeft;
  left->cameraParams = pair.leftCamera;
  left->cameraPose = T_B_L;
  if (!pair.hasImageRight) return {left};
  auto right = imageLike(pair, labels.right);
  right->image = pair.imageRight;
  right->cameraParams = pair.rightCamera;
  right->cameraPose = T_B_L + poseOf(pair.rightCameraPose, "right");
  return {left, right};
}

CObservationStereoImages::Ptr pairOf(const CObservationImage& left,
                                     const CObservationImage& right) {
  auto pair = std::make_shared<CObservationStereoImages>();
  pair->timestamp = left.timestamp;
  pair->sensorLabel = left.sensorLabel;
  pair->imageLeft = left.image;
  pair->imageRight = right.image;
  pair->hasImageRight = true;
  pair->leftCamera = left.cameraParams;
  pair->rightCamera = right.cameraParams;
  pair->cameraPose = quatOf(left.cameraPose);
  pair->rightCameraPose = quatOf(right.cameraPose - left.cameraPose);
  return pair;
}

std::vector<CObservationImage::Ptr> halvesOf(const CObservationImage& wide,
                                             const PairLabels& labels) {
  const cv::Mat& pixels = wide.image.asCvMatRef();
  if (pixels.cols < 2 || pixels.rows < 1 || pixels.cols % 2 != 0) {
    throw std::invalid_argument("an image of " + std::to_string(pixels.cols) + "x" +
                                std::to_string(pixels.rows) + " pixels holds no two views");
  }
  const int half = pixels.cols / 2;
  std::vector<CObservationImage::Ptr> out;
  for (const auto& [label, from] : {std::pair{labels.left, 0}, std::pair{labels.right, half}}) {
    auto image = imageLike(wide, label);
    image->image =
        mrpt::img::CImage(pixels.colRange(from, from + half).clone(), mrpt::img::SHALLOW_COPY);
    image->cameraParams = wide.cameraParams;
    image->cameraPose = wide.cameraPose;
    out.push_back(image);
  }
  return out;
}

std::vector<CObservation::Ptr> PairJoiner::add(const CObservation::Ptr& observation) {
  std::vector<CObservation::Ptr> out;
  if (!waiting_.empty() && waiting_.front()->timestamp != observation->timestamp) out = finish();
  waiting_.push_back(observation);
  return out;
}

std::vector<CObservation::Ptr> PairJoiner::finish() {
  join();
  return std::exchange(waiting_, {});
}

void PairJoiner::join() {
  const auto labelled = [this](const std::string& label) {
    return std::find_if(waiting_.begin(), waiting_.end(), [&](const CObservation::Ptr& o) {
      return o->sensorLabel == label && std::dynamic_pointer_cast<CObservationImage>(o);
    });
  };
  const auto left = labelled(labels_.left), right = labelled(labels_.right);
  if (left != waiting_.end() && right != waiting_.end()) {
    *left = pairOf(dynamic_cast<const CObservationImage&>(**left),
                   dynamic_cast<const CObservationImage&>(**right));
    waiting_.erase(right);
    ++pairs_;
  } else if (left != waiting_.end() || right != waiting_.end()) {
    ++single_;
  }
}

}  // namespace vir::rawlog
