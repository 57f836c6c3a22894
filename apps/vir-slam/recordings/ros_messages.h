#pragma once
/// Our observations and results as standard messages of ROS 2.
#include <map>
#include <string>
#include <vector>

#include "vir/bags/mcap_writer.h"
#include "vir/bags/message_sink.h"
#include "vir/types/calibration.h"
#include "vir/types/imu_sample.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::app {

/// Topics are made when they are first written to. Throws what the sink throws.
class RosMessages {
 public:
  /// `sink` outlives this.
  explicit RosMessages(bags::MessageSink* sink) : sink_(*sink) {}

  /// What the sink is told of a topic when it is first written to.
  void describe(const std::string& topic, const bags::Metadata& metadata) {
    metadata_[topic] = metadata;
  }
  void imu(const std::string& topic, const std::string& frame, const ImuSample& s);
  /// `encoding`: mono8 or bgr8.
  void image(const std::string& topic, const std::string& frame, TimeNs t, int width, int height,
             const std::string& encoding, const std::uint8_t* pixels);
  /// `format`: jpeg or png.
  void compressedImage(const std::string& topic, const std::string& frame, TimeNs t,
                       const std::string& format, const std::string& bytes);
  /// Makes the topic before there is an image, for clients to ask for; the sink's number of it.
  std::uint16_t advertiseCompressedImage(const std::string& topic);
  /// False for a lens that CameraInfo has no words for; nothing is written then.
  bool cameraInfo(const std::string& topic, const std::string& frame, TimeNs t,
                  const CameraCalibration& c);
  void pose(const std::string& topic, const std::string& frame, const StampedPose& pose);
  /// `covariance`: of the position [m^2].
  void pose(const std::string& topic, const std::string& frame, const StampedPose& pose,
            const Mat3& covariance);
  void odometry(const std::string& topic, const std::string& frame, const std::string& child,
                const StampedPose& pose);
  /// With its covariance and the velocity in `child`.
  void odometry(const std::string& topic, const std::string& frame, const std::string& child,
                const StateEstimate& estimate);
  void path(const std::string& topic, const std::string& frame, TimeNs t,
            const std::vector<StampedPose>& poses);
  void transform(const std::string& topic, const std::string& frame, const std::string& child,
                 const StampedPose& pose);
  /// vir_slam/Range: anchor, distance, sigma, antenna in the body, and what the anchor is called if
  /// that is no number that fits.
  void range(const std::string& topic, const std::string& frame, const Range& r,
             const std::string& name = {});
  void points(const std::string& topic, const std::string& frame, TimeNs t,
              const std::vector<Eigen::Vector3f>& points);
  /// An anchor with its ellipsoid of three standard deviations.
  struct Ellipsoid {
    std::string name;
    Vec3 p = Vec3::Zero();
    Mat3 covariance = Mat3::Zero();
  };
  void ellipsoids(const std::string& topic, const std::string& frame, TimeNs t,
                  const std::vector<Ellipsoid>& all);

 private:
  void write(const std::string& topic, const std::string& type, TimeNs t,
             const bags::CdrWriter& message);
  std::uint16_t channel(const std::string& topic, const std::string& type);

  bags::MessageSink& sink_;
  std::map<std::string, std::uint16_t> channels_;  // by topic
  std::map<std::string, bags::Metadata> metadata_;
};

}  // namespace vir::app
