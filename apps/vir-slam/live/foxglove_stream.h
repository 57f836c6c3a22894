#pragma once
/// A run as Foxglove shows it while it goes on: poses, anchors, map points, images with tracks,
/// plots and log (docs/live.md).
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/core/settings.h"
#include "vir/results/run_observer.h"

namespace vir::app {

/// Section [Foxglove].
struct FoxgloveOptions {
  int port = 0;  ///< 0: none
  std::string address = "127.0.0.1";
  int clients = 8;
  std::string token;  ///< empty: none
  double image_rate_hz = 10;
  double speed = 1;  ///< of a recording that is played by `run`; 0: as fast as it goes
};

void describe(OptionVisitor& v, FoxgloveOptions& o);

/// Never holds up who calls it: what clients do not ask for is not made, and pictures are made in a
/// thread of its own.
class FoxgloveStream final : public results::RunObserver {
 public:
  /// `used_ini`: the settings that clients may read. Throws std::runtime_error when it cannot
  /// listen.
  FoxgloveStream(const FoxgloveOptions& options, const std::string& used_ini);
  ~FoxgloveStream() override;

  void onObservation(const mrpt::obs::CObservation& observation) override;
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  /// Per reading of the IMU, between estimates. Any thread.
  void onPose(const State& state);
  /// Any thread.
  void onLog(LogLevel level, const std::string& line);

  /// From now on onOutput() returns no sooner than the recording goes on, `speed` times as fast.
  void pace(double speed);
  /// True when somebody has connected, false when `stop` says so.
  bool waitForClient(const std::function<bool()>& stop) const;

  int port() const;
  /// "Foxglove on port ...: ..." for the end.
  std::string report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// For a recording that is played: at port 8765 if none is set, at its `speed`; says where and
/// waits for somebody to look, or to be interrupted.
std::unique_ptr<FoxgloveStream> showInFoxglove(FoxgloveOptions options,
                                               const std::string& used_ini);

}  // namespace vir::app
