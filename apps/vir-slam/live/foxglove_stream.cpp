#include "live/foxglove_stream.h"

#include <mrpt/obs/CObservationImage.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <thread>
#include <utility>

#include "live/foxglove_json.h"
#include "live/pace.h"
#include "output/console.h"
#include "recordings/ros_messages.h"
#include "vir/core/host_clock.h"
#include "vir/live/foxglove_server.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace {

constexpr const char* kWorld = "world";
constexpr const char* kBody = "imu";
constexpr const char* kCamera = "cam0";
constexpr TimeNs kPoseEvery = 20'000'000;  // [ns]
constexpr TimeNs kMapEvery = 1'000'000'000;
constexpr std::size_t kMostPathPoints = 4000;
constexpr int kJpegQuality = 80;
constexpr int kUsualPort = 8765;  // where Foxglove looks first
constexpr std::chrono::milliseconds kLook{50};

/// Messages of ROS 2 to clients; the number of a channel is the server's.
class ClientSink : public bags::MessageSink {
 public:
  explicit ClientSink(live::FoxgloveServer* server) : server_(*server) {}

  std::uint16_t channel(const std::string& topic, const std::string& type,
                        const std::string& definition, const bags::Metadata&) override {
    live::FoxgloveServer::Channel c;
    c.topic = topic;
    c.encoding = "cdr";
    c.schema_name = bags::longName(type);
    c.schema_encoding = "ros2msg";
    c.schema = definition;
    c.latched = topic == "/tf_static" || type == "sensor_msgs/CameraInfo" ||
                type == "visualization_msgs/MarkerArray" || type == "sensor_msgs/PointCloud2" ||
                type == "nav_msgs/Path";
    return static_cast<std::uint16_t>(server_.advertise(c));
  }
  void write(std::uint16_t channel, TimeNs t, const bags::Bytes& cdr) override {
    server_.send(channel, t, std::string(cdr.begin(), cdr.end()));
  }

 private:
  live::FoxgloveServer& server_;
};

/// Sections and keys of an ini as names.
live::FoxgloveParameters parametersOf(const std::string& ini) {
  live::FoxgloveParameters out;
  const Settings settings = Settings::fromText(ini, "used.ini");
  for (const Setting& s : settings.all()) {
    const bool secret = s.key.find("token") != std::string::npos;
    out.emplace_back(s.section + "." + s.key, secret ? "(not told)" : s.value);
  }
  return out;
}

}  // namespace

void describe(OptionVisitor& v, FoxgloveOptions& o) {
  v.section("Foxglove", "The run as Foxglove shows it while it goes on (docs/live.md)");
  v.value("port", o.port, {0, 65535}, "of the WebSocket, usually 8765; 0 = none");
  v.value("address", o.address, "of the interface to listen on; 0.0.0.0 = all");
  v.value("clients", o.clients, {1, 64}, "how many may be connected at a time");
  v.value("token", o.token, "clients must come to ws://host:port/?token=...; empty: anybody may");
  v.value("speed", o.speed, {0, 1000}, "at which `run` plays; 0 = as fast as it goes");
  v.value("image_rate_hz", o.image_rate_hz, {0, 100}, "of images at most, 0 = none");
}

class FoxgloveStream::Impl {
 public:
  Impl(const FoxgloveOptions& options, const std::string& used_ini)
      : options_(options),
        server_(options.address, options.port, serverOptions(options)),
        sink_(&server_),
        out_(&sink_) {
    server_.setParameters(parametersOf(used_ini));
    StateEstimate no_estimate;
    health_ = json("/health", "vir_slam.Health", healthJson(no_estimate), false);
    ranges_ = json("/range_residuals", "vir_slam.RangeResidual", rangeJson({}), false);
    log_ = json("/log", "foxglove.Log", logJson(0, LogLevel::info, ""), true);
    tracks_ = json("/cam0/tracks", "foxglove.ImageAnnotations", annotationsJson(0, {}), false);
    image_ = out_.advertiseCompressedImage("/cam0/image_raw/compressed");
    painter_ = std::thread([this] { paint(); });
  }

  ~Impl() {
    {
      const std::lock_guard<std::mutex> lock(picture_mutex_);
      stop_ = true;
    }
    picture_ready_.notify_one();
    painter_.join();
  }

  void observe(const mrpt::obs::CObservation& o) {
    if (const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&o)) {
      if (o.sensorLabel == rawlog::kCameraLabel) see(*image);
      return;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto sample = rawlog::imuSampleOf(o)) {
      out_.imu("/imu0", kBody, *sample);
    } else {
      for (const Range& r : rawlog::rangesOf(o)) out_.range("/uwb0", kBody, r);
    }
  }

  void show(const roles::EstimatorOutput& output, const roles::Estimator& estimator) {
    tell(output, estimator);
    if (speed_ <= 0 || output.states.empty()) return;
    const double left = pace_.secondsUntil(output.states.back().state.t, speed_);
    std::this_thread::sleep_for(std::chrono::duration<double>(left));
  }

  void pose(const State& state) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (state.t >= next_pose_ || next_pose_ - state.t > kMapEvery) showPose({state.t, state.T_W_B});
  }

  void say(LogLevel level, const std::string& line) {
    const TimeNs now = hostNow();
    send(log_, now, logJson(now, level, line));
  }

  void pace(double speed) { speed_ = speed; }

  bool waitForClient(const std::function<bool()>& stop) const {
    while (server_.clients() == 0) {
      if (stop()) return false;
      std::this_thread::sleep_for(kLook);
    }
    return true;
  }

  int port() const { return server_.port(); }
  std::string report() const {
    return "Foxglove on port " + std::to_string(server_.port()) + ": " +
           std::to_string(server_.clients()) + " clients at the end, " +
           std::to_string(server_.refused()) + " sent away, " + std::to_string(server_.dropped()) +
           " messages left out for slow ones";
  }

 private:
  void tell(const roles::EstimatorOutput& output, const roles::Estimator& estimator) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const RangeRecord& r : output.ranges) send(ranges_, r.t, rangeJson(r));
    for (const StateEstimate& e : output.states) {
      send(health_, e.state.t, healthJson(e));
      if (server_.wanted(tracks_)) {
        send(tracks_, e.t_image, annotationsJson(e.t_image, estimator.trackedPixels()));
      }
      if (!e.valid) continue;
      out_.odometry("/odometry", kWorld, kBody, e);
      showPose({e.state.t, e.state.T_W_B});
      lengthenPath({e.state.t, e.state.T_W_B});
      showMap(e, estimator);
    }
  }

  static live::FoxgloveServerOptions serverOptions(const FoxgloveOptions& o) {
    live::FoxgloveServerOptions out;
    out.max_clients = o.clients;
    out.token = o.token;
    return out;
  }

  std::uint32_t json(const std::string& topic, const std::string& schema, const Json& example,
                     bool latched) {
    live::FoxgloveServer::Channel c;
    c.topic = topic;
    c.encoding = "json";
    c.schema_name = schema;
    c.schema_encoding = "jsonschema";
    c.schema = schemaOf(schema, example);
    c.latched = latched;
    return server_.advertise(c);
  }

  void send(std::uint32_t channel, TimeNs t, const Json& message) {
    server_.send(channel, t, message.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  void showPose(const StampedPose& pose) {
    out_.transform("/tf", kWorld, kBody, pose);
    next_pose_ = pose.t + kPoseEvery;
  }

  /// Twice as far apart whenever there are too many.
  void lengthenPath(const StampedPose& pose) {
    if (path_count_++ % path_every_ != 0) return;
    path_.push_back(pose);
    if (path_.size() < kMostPathPoints) return;
    path_every_ *= 2;
    for (std::size_t i = 0; 2 * i < path_.size(); ++i) path_[i] = path_[2 * i];
    path_.resize(path_.size() / 2);
  }

  void showMap(const StateEstimate& e, const roles::Estimator& estimator) {
    if (!e.keyframe || (e.state.t < next_map_ && next_map_ - e.state.t <= kMapEvery)) return;
    next_map_ = e.state.t + kMapEvery;
    out_.path("/path", kWorld, e.state.t, path_);
    std::vector<RosMessages::Ellipsoid> anchors;
    for (const Anchor& a : estimator.anchors()) {
      if (!a.has_position || !a.p_W.allFinite() || !a.covariance.allFinite()) continue;
      anchors.push_back({"anchor " + std::to_string(a.id), a.p_W, a.covariance});
    }
    out_.ellipsoids("/anchors", kWorld, e.state.t, anchors);
    std::vector<Eigen::Vector3f> points;
    for (const Landmark& l : estimator.landmarks()) {
      if (l.p_W.allFinite()) points.emplace_back(l.p_W.cast<float>());
    }
    out_.points("/landmarks", kWorld, e.state.t, points);
    if (e.calibration.camera.fx > 0) {
      out_.transform("/tf_static", kBody, kCamera, {e.state.t, e.calibration.T_B_C});
      out_.cameraInfo("/cam0/camera_info", kCamera, e.t_image, e.calibration.camera);
    }
  }

  /// Keeps the newest picture for the painter, if somebody looks.
  void see(const mrpt::obs::CObservationImage& image) {
    const TimeNs t = rawlog::fromMrptTime(image.timestamp);
    if (options_.image_rate_hz <= 0 || !server_.wanted(image_)) return;
    if (t < next_image_ && next_image_ - t <= kMapEvery) return;
    next_image_ = t + fromSeconds(1 / options_.image_rate_hz);
    const cv::Mat pixels = rawlog::grayOf(image);
    if (pixels.depth() != CV_8U) return;
    {
      const std::lock_guard<std::mutex> lock(picture_mutex_);
      pixels.copyTo(picture_);  // they are the observation's
      picture_t_ = t;
    }
    picture_ready_.notify_one();
  }

  void paint() {
    std::vector<unsigned char> jpeg;
    cv::Mat pixels;
    while (true) {
      TimeNs t = 0;
      {
        std::unique_lock<std::mutex> lock(picture_mutex_);
        picture_ready_.wait(lock, [this] { return stop_ || !picture_.empty(); });
        if (stop_) return;
        pixels = std::exchange(picture_, cv::Mat());
        t = picture_t_;
      }
      cv::imencode(".jpg", pixels, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
      const std::lock_guard<std::mutex> lock(mutex_);
      out_.compressedImage("/cam0/image_raw/compressed", kCamera, t, "jpeg",
                           std::string(jpeg.begin(), jpeg.end()));
    }
  }

  const FoxgloveOptions options_;
  live::FoxgloveServer server_;
  ClientSink sink_;
  std::uint32_t health_ = 0, ranges_ = 0, log_ = 0, tracks_ = 0, image_ = 0;

  std::mutex mutex_;  // of what follows
  RosMessages out_;
  TimeNs next_pose_ = 0, next_map_ = 0;
  std::vector<StampedPose> path_;
  std::size_t path_every_ = 1, path_count_ = 0;

  double speed_ = 0;
  Pace pace_;

  TimeNs next_image_ = 0;  // of the thread that observes
  std::mutex picture_mutex_;
  std::condition_variable picture_ready_;
  cv::Mat picture_;
  TimeNs picture_t_ = 0;
  bool stop_ = false;
  std::thread painter_;
};

FoxgloveStream::FoxgloveStream(const FoxgloveOptions& options, const std::string& used_ini)
    : impl_(std::make_unique<Impl>(options, used_ini)) {}
FoxgloveStream::~FoxgloveStream() = default;

void FoxgloveStream::onObservation(const mrpt::obs::CObservation& observation) {
  impl_->observe(observation);
}
void FoxgloveStream::onOutput(const roles::EstimatorOutput& output,
                              const roles::Estimator& estimator) {
  impl_->show(output, estimator);
}
void FoxgloveStream::onPose(const State& state) { impl_->pose(state); }
void FoxgloveStream::onLog(LogLevel level, const std::string& line) { impl_->say(level, line); }
void FoxgloveStream::pace(double speed) { impl_->pace(speed); }
bool FoxgloveStream::waitForClient(const std::function<bool()>& stop) const {
  return impl_->waitForClient(stop);
}
int FoxgloveStream::port() const { return impl_->port(); }
std::string FoxgloveStream::report() const { return impl_->report(); }

std::unique_ptr<FoxgloveStream> showInFoxglove(FoxgloveOptions options,
                                               const std::string& used_ini) {
  if (options.port == 0) options.port = kUsualPort;
  auto stream = std::make_unique<FoxgloveStream>(options, used_ini);
  stream->pace(options.speed);
  std::fprintf(stderr,
               "waiting for Foxglove: open the connection ws://localhost:%d (Ctrl-C ends)\n",
               stream->port());
  if (!stream->waitForClient(interrupted)) std::fprintf(stderr, "nobody came\n");
  return stream;
}

}  // namespace vir::app
