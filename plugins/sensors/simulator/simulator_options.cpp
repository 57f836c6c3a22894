#include "simulator_options.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <sstream>

#include "vir/core/angles.h"
#include "vir/core/random.h"
#include "vir/core/settings.h"

namespace vir::simulator {
namespace {

constexpr Bounds<double> kNotNegative{0.0, 1e6};
constexpr Bounds<double> kPixels{1.0, 20000.0};

[[noreturn]] void refuse(const char* key, const std::string& problem) {
  throw SettingsError(SettingOrigin(), "simulator", key, problem);
}

/// Further cameras stand beside the first, to its right [m].
constexpr double kBaseline_m = 0.11;

void describeFaults(OptionVisitor& v, CameraOptions& o) {
  v.value("black_s", o.black_s, 0, "from to, from to ...: its images are black");
  v.value("frozen_s", o.frozen_s, 0, "from to ...: the last image comes again and again");
  v.value("missing_s", o.missing_s, 0, "from to ...: no images");
  v.value("half_rate_s", o.half_rate_s, 0, "from to ...: only every second image");
}

void describeCamera(OptionVisitor& v, const std::string& section, const char* about,
                    CameraOptions& o) {
  v.section(section, about);
  v.value("rate_hz", o.rate_hz, {0.1, 1000.0}, "images per second (of tracks: [SimulatedTracks])");
  v.value("phase_s", o.phase_s, kNotNegative, "of the first image after the first IMU reading");
  v.value("time_offset_s", o.time_offset_s, {-1.0, 1.0},
          "stamp of an image + this = time on the IMU's clock");
  v.value("readout_s", o.readout_s, {0.0, 0.2},
          "rolling shutter: time from an image's first row to its last; 0 = all at once");
  v.value("width_px", o.width, {16, 10000}, "of the images");
  v.value("height_px", o.height, {16, 10000}, "of the images");
  v.value("fx_px", o.fx_px, kPixels, "focal length");
  v.value("fy_px", o.fy_px, kPixels, "focal length");
  v.value("cx_px", o.cx_px, {0.0, 10000.0}, "principal point");
  v.value("cy_px", o.cy_px, {0.0, 10000.0}, "principal point");
  v.choice("distortion", o.distortion, {"none", "radtan", "equidistant"}, "model of the lens");
  v.value("dist", o.dist, 5, "radtan: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4 0");
  v.choice(
      "mount", o.mount, {"forward", "backward", "left", "right", "down", "euroc"},
      "looks along the body's x, against it, to a side, down, or along z with the body's x up");
  v.value("tilt_deg", o.tilt_deg, {-90.0, 90.0}, "downwards, if it looks to the horizon");
  v.value("position_m", o.position_m, 3, "in the body");
  v.value("focal_error", o.focal_error, {0.0, 0.2},
          "the focal length is off by this share of what the recording says (standard deviation)");
  v.value("center_error_px", o.center_error_px, {0.0, 100.0},
          "the same of the principal point, per axis");
  v.value("mount_error_deg", o.mount_error_deg, {0.0, 45.0}, "the same of its attitude, per axis");
  v.value("mount_error_m", o.mount_error_m, {0.0, 1.0}, "the same of its place, per axis");
  v.value("clock_error_s", o.clock_error_s, {-1.0, 1.0},
          "its time offset is this much more than time_offset_s says");
  describeFaults(v, o);
}

/// Where not said otherwise, a further camera is the first one again, beside it.
void describeFurtherCameras(OptionVisitor& v, SimulatorOptions& o) {
  o.further_cameras.clear();
  for (int k = 1; k < o.cameras; ++k) {
    CameraOptions c = o.camera;
    const Vec3 beside = mountOf(o.camera) * Vec3(k * kBaseline_m, 0, 0);
    c.position_m = {beside.x(), beside.y(), beside.z()};
    for (auto* fault : {&c.black_s, &c.frozen_s, &c.missing_s, &c.half_rate_s}) fault->clear();
    describeCamera(v, "Camera" + std::to_string(k), "A further camera; by default as [Camera]", c);
    o.further_cameras.push_back(c);
  }
}

void describeRobot(OptionVisitor& v, char letter, RobotOptions& o) {
  v.section(std::string("Robot_") + letter, std::string("Where robot ") + letter + " goes");
  v.choice("flight", o.flight, simulation::flightNames(), "a made-up flight");
  v.value("trajectory", o.trajectory, "a file (TUM or EuRoC) with poses to fly again instead");
  v.value("from_s", o.from_s, kNotNegative, "leave out this much of the file");
  v.value("duration_s", o.duration_s, kNotNegative, "stop after this much; 0 = to the end");
  v.value("length_m", o.length_m, kNotNegative, "of the flight; 0 = as [Flight] says");
  v.value("speed_mps", o.speed_mps, {0.0, 50.0}, "of the flight; 0 = as [Flight] says");
  v.value("start_m", o.start_m, 3, "where the flight begins in the world; moves a file's poses");
  v.value("start_heading_deg", o.start_heading_deg, {-360.0, 360.0}, "and how it is turned");
}

void describeSensor(OptionVisitor& v, SimulatorOptions& o) {
  v.section("simulator", "Recordings of robots in a made-up world");
  v.value("robots", o.robots, "letters of the robots, with blanks between");
  v.value("robot", o.robot, "letter of the robot whose recording it is; empty = the first");
  v.choice("images", o.images, {"external", "embed", "none"},
           "images beside the rawlog, inside it, or none");
  v.choice("image_format", o.image_format, {"jpg", "png"}, "of external images");
  v.value("jpeg_quality", o.jpeg_quality, {1, 100}, "of external images");
  v.value("cameras", o.cameras, {1, 8},
          "cameras of each robot (CAM0, CAM1, ...): [Camera], [Camera1] ...");
  v.value("tracks", o.tracks, "feature tracks (label TRACKS0) instead of images");
  v.value("ranges", o.ranges, "ranges to anchors and, with several robots, between them");
  v.value("odometry", o.odometry, "poses of a device with odometry of its own (label ODOM)");
  v.value("read_gt", o.read_gt, "take over the ground truth (evaluation only)");
  v.value("gt_rate_hz", o.gt_rate_hz, {0.1, 1000.0}, "poses of the ground truth per second");
  v.value("start_time_s", o.start_time_s, {0.0, 9e9}, "stamp of the first IMU reading");
  v.value("seed", o.seed, {0, 1000000}, "added to all seeds: another run of the same kind");
}

}  // namespace

void describe(OptionVisitor& v, SimulatorOptions& o) {
  describeSensor(v, o);
  for (const char letter : lettersOf(o)) describeRobot(v, letter, o.robot_options[letter]);
  describe(v, o.flight);
  describeCamera(v, "Camera", "The camera all robots carry", o.camera);
  describeFurtherCameras(v, o);
  describe(v, o.scene);
  describe(v, o.camera_effects);
  describe(v, o.imu);
  describe(v, o.track_errors);
  describe(v, o.range_errors);
  describe(v, o.team);
  describe(v, o.odometry_errors);
}

std::vector<char> lettersOf(const SimulatorOptions& o) {
  std::vector<char> out;
  std::istringstream in(o.robots);
  for (std::string word; in >> word;) {
    const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
    const bool good = word.size() == 1 && letter >= 'A' && letter <= 'Z' &&
                      std::find(out.begin(), out.end(), letter) == out.end();
    if (!good) {
      refuse("robots",
             o.robots + ": give single letters with blanks between, each once, as in A B");
    }
    out.push_back(letter);
  }
  if (out.empty()) refuse("robots", "is empty: give letters with blanks between, as in A B");
  return out;
}

char recordedRobot(const SimulatorOptions& o) {
  const std::vector<char> letters = lettersOf(o);
  if (o.robot.empty()) return letters.front();
  const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(o.robot[0])));
  if (o.robot.size() != 1 || std::find(letters.begin(), letters.end(), letter) == letters.end()) {
    refuse("robot", o.robot + ": is none of the robots " + o.robots);
  }
  return letter;
}

int robotId(char letter) { return std::toupper(static_cast<unsigned char>(letter)) - 'A'; }

CameraCalibration calibrationOf(const CameraOptions& o) {
  CameraCalibration c;
  c.width = o.width;
  c.height = o.height;
  c.fx = o.fx_px;
  c.fy = o.fy_px;
  c.cx = o.cx_px;
  c.cy = o.cy_px;
  if (o.distortion == "radtan") c.distortion = Distortion::radtan;
  if (o.distortion == "equidistant") c.distortion = Distortion::equidistant;
  if (o.distortion != "none") std::copy(o.dist.begin(), o.dist.end(), c.dist.begin());
  return c;
}

Pose mountOf(const CameraOptions& o) {
  Mat3 forward, down, euroc;
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  down << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  euroc << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Quat tilt = expQuat(Vec3(-o.tilt_deg * kPi / 180, 0, 0));
  Quat q = Quat(forward) * tilt;
  if (o.mount == "backward") q = Quat(rotZ(kPi)) * q;
  if (o.mount == "left") q = Quat(rotZ(kPi / 2)) * q;
  if (o.mount == "right") q = Quat(rotZ(-kPi / 2)) * q;
  if (o.mount == "down") q = Quat(down);
  if (o.mount == "euroc") q = Quat(euroc);
  return {q.normalized(), Vec3(o.position_m[0], o.position_m[1], o.position_m[2])};
}

TrueCamera trueCamera(const CameraOptions& o, int seed) {
  Random random(static_cast<std::uint64_t>(seed), 550);
  TrueCamera c{calibrationOf(o), mountOf(o)};
  const double stretch = 1 + o.focal_error * random.normal();
  c.calibration.fx *= stretch;
  c.calibration.fy *= stretch;
  c.calibration.cx += o.center_error_px * random.normal();
  c.calibration.cy += o.center_error_px * random.normal();
  const double x = random.normal(), y = random.normal(), z = random.normal();
  c.T_B_C.q = (c.T_B_C.q * expQuat(o.mount_error_deg * kPi / 180 * Vec3(x, y, z))).normalized();
  const double u = random.normal(), n = random.normal(), w = random.normal();
  c.T_B_C.p += o.mount_error_m * Vec3(u, n, w);
  return c;
}

}  // namespace vir::simulator
