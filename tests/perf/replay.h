#pragma once
/// The packets of a recording, and either half of the estimator working on them alone.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "back_end.h"
#include "front_end.h"
#include "vir_estimator.h"

namespace vir::tool {

/// CPU time of one image by stage [ms], under the names of frames.csv.
using Stages = std::map<std::string, double>;

/// A run as it was: what the front end sent, and what it was told before each image.
struct Replayed {
  std::vector<estimator::Packet> packets;
  std::vector<estimator::Feedback> told;
  std::vector<StateEstimate> states;         ///< in the order of the packets that are images
  std::map<std::string, long> other_images;  ///< by label: not taken
};

class Replay {
 public:
  /// Throws std::runtime_error if the recording has no image of the camera, or cannot be read.
  Replay(std::string rawlog, VirSettings settings);
  /// Both halves in turn, as in a run without loops; how it went is kept for the others.
  const Replayed& run();
  /// Images to tracks, given the feedback of run(); the packets are said in their order, with the
  /// time that decoding their images took [ms]. Throws std::runtime_error if they are not the same.
  void frontEnd(const std::function<void(const estimator::Packet&, double decode_ms)>& each) const;
  /// The packets of run() to states. Throws std::runtime_error if they are not the same.
  void backEnd(const std::function<void(const StateEstimate&, double total_ms)>& each) const;

 private:
  void play(estimator::FrontEnd* front_end, std::map<TimeNs, double>* decode_ms,
            std::map<std::string, long>* others) const;

  std::string rawlog_;
  VirSettings settings_;
  estimator::EstimatorConfig config_;
  Calibration calibration_;
  Replayed run_;
};

}  // namespace vir::tool
