#include "world.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "input_error.h"
#include "rig.h"
#include "vir/core/angles.h"
#include "vir/core/text_stream.h"
#include "vir/evaluation/trajectory.h"

namespace vir::simulator {
namespace {

/// Poses per second of the paths the scene is built around.
constexpr double kPathRate_hz = 5;
/// The robots' random numbers have seeds this far apart.
constexpr int kSeedsPerRobot = 1000;

/// Poses moved by the robot's start: turned about the first and shifted.
Trajectory placed(Trajectory poses, const RobotOptions& o) {
  const Vec3 start(o.start_m[0], o.start_m[1], o.start_m[2]);
  const Vec3 first = poses.front().T_W_B.p;
  const Quat turn(rotZ(o.start_heading_deg * kPi / 180));
  for (StampedPose& s : poses) {
    s.T_W_B.p = first + start + turn * (s.T_W_B.p - first);
    s.T_W_B.q = (turn * s.T_W_B.q).normalized();
  }
  return poses;
}

Trajectory readPoses(const RobotOptions& o, const std::string& key) {
  TextStream in(o.trajectory);
  if (!in) throw InputError(key + " = " + o.trajectory + ": no such file");
  evaluation::ReadReport report;
  Trajectory poses = evaluation::readTrajectory(in, &report);
  if (poses.size() < 2) throw InputError(key + " = " + o.trajectory + " holds no poses");
  return placed(std::move(poses), o);
}

/// The motion with its begin at `begin`, cut after `duration_s` if that is not 0.
simulation::Motion begunAt(const simulation::Motion& motion, TimeNs begin, double duration_s) {
  constexpr double kKnot_s = 0.05;
  Trajectory poses;
  const double whole = motion.duration();
  const double duration = duration_s > 0 ? std::min(duration_s, whole) : whole;
  for (int k = 0; k * kKnot_s <= duration + 1e-9; ++k) {
    const TimeNs s = std::min(fromSeconds(k * kKnot_s), motion.end() - motion.begin());
    poses.push_back({begin + s, motion.poseAt(motion.begin() + s)});
  }
  return simulation::Motion(begin, kKnot_s, poses);
}

}  // namespace

struct World::Impl {
  explicit Impl(const SimulatorOptions& o) : options(o), letter(recordedRobot(o)) {
    addSeed();
    rig.emplace(options);
    makeMotions();
    makeScene();
    record();
  }

  void addSeed();
  void makeMotions();
  simulation::Motion motionOf(char robot, int index) const;
  void makeScene();
  void record();
  void recordTruth();
  void recordImu();
  void recordRanges();
  void recordImages();

  SimulatorOptions options;
  std::optional<Rig> rig;  ///< made from the options with their seeds
  char letter;
  int index = 0;  ///< of the recorded robot among the robots
  std::vector<simulation::TeamRobot> robots;
  std::shared_ptr<const simulation::Motion> motion;
  std::shared_ptr<const rendering::Scene> scene;
  std::vector<Event> events;
  std::unique_ptr<simulation::TrackSimulator> tracks;
  std::vector<std::string> notes;
};

void World::Impl::addSeed() {
  const std::vector<char> letters = lettersOf(options);
  index = static_cast<int>(std::find(letters.begin(), letters.end(), letter) - letters.begin());
  // What all share, and what each robot has of its own.
  for (int* seed : {&options.scene.seed, &options.range_errors.seed, &options.odometry_errors.seed,
                    &options.flight.seed}) {
    *seed += options.seed;
  }
  for (int* seed : {&options.imu.seed, &options.track_errors.seed, &options.camera_effects.seed}) {
    *seed += options.seed + kSeedsPerRobot * index;
  }
}

simulation::Motion World::Impl::motionOf(char robot, int number) const {
  const RobotOptions& o = options.robot_options.at(robot);
  const TimeNs begin = fromSeconds(options.start_time_s);
  if (!o.trajectory.empty()) {
    simulation::FlyAgainOptions again;
    again.from_s = o.from_s;
    again.duration_s = o.duration_s;
    const std::string key = std::string("[Robot_") + robot + "] trajectory";
    return begunAt(simulation::flyAgain(readPoses(o, key), again), begin, 0);
  }
  simulation::FlightOptions f = options.flight;
  if (o.length_m > 0) f.length_m = o.length_m;
  if (o.speed_mps > 0) f.speed_mps = o.speed_mps;
  for (int k = 0; k < 3; ++k) {
    f.start_m[static_cast<std::size_t>(k)] += o.start_m[static_cast<std::size_t>(k)];
  }
  f.start_heading_deg += o.start_heading_deg;
  f.seed += kSeedsPerRobot * number;
  return begunAt(flight(o.flight, f), begin, o.duration_s);
}

void World::Impl::makeMotions() {
  int number = 0;
  for (const char robot : lettersOf(options)) {
    try {
      robots.push_back(
          {robotId(robot), std::make_shared<simulation::Motion>(motionOf(robot, number++))});
    } catch (const std::invalid_argument& e) {
      throw InputError(std::string("[Robot_") + robot + "]: " + e.what());
    }
  }
  motion = robots[static_cast<std::size_t>(index)].motion;
}

void World::Impl::makeScene() {
  std::vector<Vec3> paths, anchors;
  for (const simulation::TeamRobot& r : robots) {
    for (const StampedPose& s : r.motion->sampled(kPathRate_hz)) paths.push_back(s.T_W_B.p);
  }
  const std::vector<double>& a = options.range_errors.anchor_m;
  for (std::size_t k = 0; options.ranges && k + 3 <= a.size(); k += 3) {
    anchors.emplace_back(a[k], a[k + 1], a[k + 2]);
  }
  scene =
      std::make_shared<rendering::Scene>(vir::rendering::makeScene(options.scene, paths, anchors));
}

void World::Impl::recordTruth() {
  if (options.read_gt) {
    for (const StampedPose& s : motion->sampled(options.gt_rate_hz)) {
      events.push_back({s.t, TruePose{s.T_W_B}});
    }
  }
  if (options.odometry) {
    simulation::OdometrySimulationOptions o = options.odometry_errors;
    o.seed += index;  // as the one it tells others of
    for (const StampedPose& s : simulation::simulateOdometry(*motion, o)) {
      events.push_back({s.t, OdometryPose{s.T_W_B}});
    }
  }
}

void World::Impl::recordImu() {
  for (const ImuSample& s : simulation::simulateImu(*motion, options.imu).samples) {
    events.push_back({s.t, ImuReading{s}});
  }
}

void World::Impl::recordRanges() {
  if (!options.ranges) return;
  const auto all = simulation::simulateTeamRanges(robots, options.range_errors, options.team,
                                                  options.odometry_errors, scene.get());
  const simulation::RobotRanges& own = all[static_cast<std::size_t>(index)];
  long blocked = 0;
  const std::vector<simulation::SimulatedRange> differences =
      options.range_errors.differences
          ? simulation::simulateRangeDifferences(*motion, options.range_errors, scene.get())
          : std::vector<simulation::SimulatedRange>();
  const auto& to_anchors = options.range_errors.differences ? differences : own.anchors;
  for (const simulation::SimulatedRange& r : to_anchors) {
    events.push_back({r.t, AnchorRange{r}});
    blocked += r.line_of_sight ? 0 : 1;
  }
  for (const simulation::PeerRange& p : own.peers) {
    events.push_back({p.range.t, p});
    blocked += p.range.line_of_sight ? 0 : 1;
  }
  notes.push_back(std::to_string(to_anchors.size() + own.peers.size()) +
                  (options.range_errors.differences ? " differences of ranges, " : " ranges, ") +
                  std::to_string(blocked) + " without line of sight");
}

void World::Impl::recordImages() {
  if (options.tracks) {
    const TimeNs offset = fromSeconds(options.camera.trueOffset());
    options.track_errors.readout_s = options.camera.readout_s;
    tracks = std::make_unique<simulation::TrackSimulator>(options.track_errors, motion,
                                                          rig->model(0), rig->trueT_B_C(0), scene);
    for (const TimeNs t : tracks->times()) events.push_back({t - offset, TracksDue{}});
    if (rig->size() > 1) notes.push_back("tracks are those of the first camera alone");
    return;
  }
  if (options.images == "none") return;
  rig->look(scene, motion);
  for (int camera = 0; camera < rig->size(); ++camera) {
    for (const auto& [t, number] : rig->stamps(camera)) {
      events.push_back({t, ImageDue{number, camera}});
    }
  }
}

void World::Impl::record() {
  recordTruth();
  recordImu();
  recordRanges();
  recordImages();
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  notes.push_back("robot " + std::string(1, letter) + ": " +
                  std::to_string(std::round(10 * motion->pathLength()) / 10).substr(0, 6) +
                  " m in " + std::to_string(std::lround(motion->duration())) + " s among " +
                  std::to_string(scene->boxes().size()) + " boxes");
}

World::World(const SimulatorOptions& options) {
  try {
    impl_ = std::make_unique<Impl>(options);
  } catch (const std::invalid_argument& e) {
    throw InputError(e.what());
  }
}
World::~World() = default;

const std::vector<Event>& World::events() const { return impl_->events; }

const rendering::GrayImage& World::image(const Event& event) {
  const ImageDue& due = std::get<ImageDue>(event.what);
  return impl_->rig->image(due.camera, event.t, due.number);
}

vision::TrackedFrame World::tracks(const Event& event) {
  vision::TrackedFrame frame =
      impl_->tracks->at(event.t + fromSeconds(impl_->options.camera.trueOffset()));
  frame.t = event.t;
  return frame;
}

int World::cameras() const { return impl_->rig->size(); }
const CameraCalibration& World::calibration(int camera) const {
  return impl_->rig->calibration(camera);
}
const Pose& World::T_B_C(int camera) const { return impl_->rig->T_B_C(camera); }
Vec3 World::antenna() const {
  const std::vector<double>& l = impl_->options.range_errors.lever_arm_m;
  return {l[0], l[1], l[2]};
}
const rendering::Scene& World::scene() const { return *impl_->scene; }
const simulation::Motion& World::motion() const { return *impl_->motion; }
std::vector<std::string> World::notes() const { return impl_->notes; }

}  // namespace vir::simulator
