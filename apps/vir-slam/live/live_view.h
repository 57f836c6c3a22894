#pragma once
/// Shows an estimate while it is made: path, robot, anchors, map points, and the image with what is
/// tracked in it; in a window or as a film.
#include <mrpt/obs/CObservation.h>

#include <memory>
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::app {

class LiveView {
 public:
  virtual ~LiveView() = default;

  /// Times are told since this, the first image of the run; before the first estimate.
  virtual void setBegin(TimeNs /*t*/) {}
  /// What there is to show of one image; any thread. Without `estimator` as a source of map points
  /// the old ones stay.
  virtual void setEstimate(const StateEstimate& estimate, const roles::Estimator& estimator) = 0;
  /// States of before that have changed; any thread.
  virtual void setRevision(const Revision& revision) = 0;
  /// The newest image and ranges; any thread.
  virtual void setObservation(const mrpt::obs::CObservation::Ptr& observation) = 0;
  /// Shows what has come since the last call, a window at most ten times per second.
  virtual void draw() = 0;
  /// The user has closed the window.
  virtual bool closed() const = 0;
  /// What has been typed into the window since the last call; 0: nothing.
  virtual char typed() { return 0; }
};

/// Opens the window. What draws is a shared object of its own, since MRPT's windows load a hundred
/// libraries that nobody else needs. Throws std::runtime_error if there is no display, or that
/// object is not where the program is installed.
std::unique_ptr<LiveView> openLiveView();

/// A film instead, of 20 images for each second of the recording over `speed`; the kind of file by
/// its name (.mp4, .avi). What writes it is a shared object of its own for the same reason. Throws
/// std::runtime_error if there can be no such file.
std::unique_ptr<LiveView> openVideoView(const std::string& file, double speed);

}  // namespace vir::app
