#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/img/CImage.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>
#include <opencv2/core/mat.hpp>

#include "companion_ini.h"
#include "input_error.h"
#include "observations.h"
#include "simulator_sensor.h"
#include "vir/core/settings.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/grabber_settings.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(SimulatorSensor, vir)

namespace {

using simulator::Event;

/// Events per doProcess(): enough to be fast, few enough to keep the queue small.
constexpr int kBatch = 64;

struct GrabberKeys {
  std::string ini, robot;
};

void describeKeys(OptionVisitor& v, GrabberKeys& o) {
  v.section("simulator", "Recordings of robots in a made-up world");
  v.value("ini", o.ini, "file with the settings of the world; empty = defaults");
  v.value("robot", o.robot, "letter of the robot; empty = as the file says");
}

}  // namespace

SimulatorSensor::SimulatorSensor() { m_sensorLabel = "SIMULATOR"; }
SimulatorSensor::~SimulatorSensor() = default;

void SimulatorSensor::describe(OptionVisitor& v) { simulator::describe(v, options_); }

void SimulatorSensor::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                                const std::string& section) {
  GrabberKeys keys;
  roles::readGrabberSection(config, section, [&keys](OptionVisitor& v) { describeKeys(v, keys); });
  Settings settings = keys.ini.empty() ? Settings() : Settings::fromFile(keys.ini);
  if (!keys.robot.empty()) settings.set("simulator.robot=" + keys.robot);
  SettingsReader reader(settings);
  describe(reader);
  reader.finish();
}

void SimulatorSensor::setPathForExternalImages(const std::string& directory) {
  m_path_for_external_images = directory;
}

void SimulatorSensor::initialize() {
  given_.clear();
  warnings_.clear();
  at_ = 0;
  m_state = ssInitializing;
  world_ = std::make_unique<simulator::World>(options_);
  warnings_ = world_->notes();
  writer_.reset();
  if (options_.images == "external" && !options_.tracks) {
    if (m_path_for_external_images.empty()) {
      warnings_.push_back("images = external: no folder for images was given; they are embedded");
    } else {
      writer_ = std::make_unique<simulator::ImageWriter>(
          m_path_for_external_images, options_.image_format, options_.jpeg_quality);
    }
  }
  image_templates_.clear();
  for (int k = 0; k < world_->cameras(); ++k) {
    image_templates_.push_back(simulator::emptyImage(k, world_->calibration(k), world_->T_B_C(k)));
  }
  m_state = ssWorking;
}

void SimulatorSensor::doProcess() {
  if (!world_) throw InputError("SimulatorSensor: doProcess() before initialize()");
  for (int i = 0; i < kBatch && !finished(); ++i) {
    const Event& event = world_->events()[at_++];
    emit(event);
    if (std::holds_alternative<simulator::ImageDue>(event.what)) return;
  }
}

void SimulatorSensor::give(TimeNs t, const char* counter,
                           const std::shared_ptr<mrpt::obs::CObservation>& obs) {
  obs->timestamp = rawlog::toMrptTime(t);
  if (counter != nullptr) ++given_[counter];
  appendObservation(obs);
}

void SimulatorSensor::emit(const Event& event) {
  const simulation::RangeSimulationOptions& r = options_.range_errors;
  const double sigma = std::max(0.01, std::hypot(r.sigma_m, r.correlated_sigma_m));
  if (const auto* imu = std::get_if<simulator::ImuReading>(&event.what)) {
    give(event.t, "imu_samples", rawlog::toObservation(imu->sample, rawlog::kImuLabel));
  } else if (const auto* truth = std::get_if<simulator::TruePose>(&event.what)) {
    give(event.t, "ground_truth_poses",
         rawlog::toObservation(StampedPose{event.t, truth->T_W_B}, rawlog::kGroundTruthLabel));
  } else if (const auto* odometry = std::get_if<simulator::OdometryPose>(&event.what)) {
    give(event.t, "odometry_poses",
         rawlog::toObservation(StampedPose{event.t, odometry->T_O_B}, rawlog::kOdometryLabel));
  } else if (const auto* range = std::get_if<simulator::AnchorRange>(&event.what)) {
    give(event.t, "ranges",
         simulator::rangeObservation(rawlog::kRangeLabel, range->range, world_->antenna(), sigma));
  } else if (const auto* peer = std::get_if<simulation::PeerRange>(&event.what)) {
    give(event.t, "peer_ranges",
         simulator::rangeObservation(rawlog::kPeerLabel, peer->range, world_->antenna(), sigma));
    for (const simulation::ToldPosition& told : peer->told) {
      give(event.t, nullptr, simulator::toldObservation(peer->range.anchor, told));
    }
  } else if (const auto* image = std::get_if<simulator::ImageDue>(&event.what)) {
    emitImage(event, image->camera);
  } else {
    give(event.t, "track_sets",
         simulator::tracksObservation(world_->tracks(event), world_->calibration(),
                                      world_->T_B_C()));
  }
}

void SimulatorSensor::emitImage(const Event& event, int camera) {
  const rendering::GrayImage& image = world_->image(event);
  const auto& all_but_pixels = *image_templates_[static_cast<std::size_t>(camera)];
  auto obs = std::make_shared<mrpt::obs::CObservationImage>(all_but_pixels);
  if (writer_) {
    obs->image.setExternalStorage(writer_->write(obs->sensorLabel, event.t, image));
  } else {
    const cv::Mat pixels(image.height, image.width, CV_8UC1,
                         const_cast<std::uint8_t*>(image.pixels.data()));
    obs->image = mrpt::img::CImage(pixels, mrpt::img::DEEP_COPY);
  }
  give(event.t, "images", obs);
}

bool SimulatorSensor::finished() const { return world_ && at_ == world_->events().size(); }

double SimulatorSensor::progress() const {
  if (!world_) return 0;
  return static_cast<double>(at_) / static_cast<double>(world_->events().size());
}

std::vector<std::pair<std::string, long>> SimulatorSensor::counters() const {
  return {given_.begin(), given_.end()};
}

std::vector<std::string> SimulatorSensor::warnings() const { return warnings_; }

std::string SimulatorSensor::companionIni() const {
  const simulation::ImuSimulationOptions& imu = options_.imu;
  const bool noisy = imu.gyro_noise_density > 0 && imu.gyro_random_walk > 0 &&
                     imu.acc_noise_density > 0 && imu.acc_random_walk > 0;
  if (!noisy) return {};
  return "// Noise of the simulated IMU\n" + imuSection(imu);
}

std::vector<roles::TrueAnchor> SimulatorSensor::trueAnchors() const {
  std::vector<roles::TrueAnchor> anchors;
  const simulation::RangeSimulationOptions& r = options_.range_errors;
  for (std::size_t k = 0; options_.ranges && 3 * k + 3 <= r.anchor_m.size(); ++k) {
    const int id = r.anchor_id.empty() ? static_cast<int>(k) : static_cast<int>(r.anchor_id[k]);
    const Vec3 p_W = simulation::anchorAt(r, k, 1e9);  // where it is in the end
    anchors.push_back({static_cast<std::uint32_t>(id), p_W});
  }
  return anchors;
}

}  // namespace vir
