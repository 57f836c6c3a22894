#pragma once
/// A window that shows a live estimate: path, robot, anchors, map points, and the image with what
/// is tracked in it.
#include <mrpt/obs/CObservation.h>

#include <memory>
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::app {

class LiveView {
 public:
  /// Opens the window. Throws std::runtime_error if there is no display.
  LiveView();
  ~LiveView();

  /// What there is to show of one image; any thread. Without `estimator` as a source of map points
  /// the old ones stay.
  void setEstimate(const StateEstimate& estimate, const roles::Estimator& estimator);
  /// States of before that have changed; any thread.
  void setRevision(const Revision& revision);
  /// The newest image and ranges; any thread.
  void setObservation(const mrpt::obs::CObservation::Ptr& observation);
  /// Shows what has come since the last call, at most ten times per second.
  void draw();
  /// The user has closed the window.
  bool closed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::app
