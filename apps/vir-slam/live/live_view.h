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
  virtual ~LiveView() = default;

  /// What there is to show of one image; any thread. Without `estimator` as a source of map points
  /// the old ones stay.
  virtual void setEstimate(const StateEstimate& estimate, const roles::Estimator& estimator) = 0;
  /// States of before that have changed; any thread.
  virtual void setRevision(const Revision& revision) = 0;
  /// The newest image and ranges; any thread.
  virtual void setObservation(const mrpt::obs::CObservation::Ptr& observation) = 0;
  /// Shows what has come since the last call, at most ten times per second.
  virtual void draw() = 0;
  /// The user has closed the window.
  virtual bool closed() const = 0;
};

/// Opens the window. What draws is a shared object of its own, since MRPT's windows load a hundred
/// libraries that nobody else needs. Throws std::runtime_error if there is no display, or that
/// object is not where the program is installed.
std::unique_ptr<LiveView> openLiveView();

}  // namespace vir::app
