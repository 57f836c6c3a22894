#include <stdexcept>

#include "vir/simulation/flights.h"
#include "vir/simulation/interval.h"
#include "vir/simulation/simulate_imu.h"
#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"
#include "vir/simulation/simulate_team_ranges.h"
#include "vir/simulation/track_simulator.h"

namespace vir::simulation {
namespace {

constexpr Bounds<double> kShare{0.0, 1.0};
constexpr Bounds<double> kNotNegative{0.0, 1e6};
constexpr Bounds<double> kRate{0.1, 10000.0};
constexpr Bounds<int> kSeed{0, 2000000000};

}  // namespace

bool insideAny(const std::vector<double>& stretches, double s) {
  if (stretches.size() % 2 != 0) {
    throw std::invalid_argument("stretches of time must be pairs (from, to); there are " +
                                std::to_string(stretches.size()) + " values");
  }
  for (std::size_t k = 0; k < stretches.size(); k += 2) {
    if (s >= stretches[k] && s < stretches[k + 1]) return true;
  }
  return false;
}

void describe(OptionVisitor& v, FlightOptions& o) {
  v.section("Flight", "A made-up flight");
  v.value("length_m", o.length_m, {0.1, 1e5}, "length of the path");
  v.value("speed_mps", o.speed_mps, {0.01, 50.0}, "speed along the path");
  v.value("rest_s", o.rest_s, kNotNegative, "standing still at both ends");
  v.value("sway_m", o.sway_m, kNotNegative, "standard deviation of the sway in position");
  v.value("sway_deg", o.sway_deg, {0.0, 45.0}, "standard deviation of the sway in attitude");
  v.value("height_m", o.height_m, kNotNegative, "amplitude of a slow change of height");
  v.value("stop_every_m", o.stop_every_m, kNotNegative,
          "standing still after every so much of the way; 0 = never");
  v.value("stop_s", o.stop_s, {0.0, 1000.0}, "for how long");
  v.value("start_m", o.start_m, 3, "where the path begins in the world");
  v.value("start_heading_deg", o.start_heading_deg, {-360.0, 360.0},
          "the whole path is turned about its beginning");
  v.value("seed", o.seed, kSeed, "of the sway");
}

void describe(OptionVisitor& v, ImuSimulationOptions& o) {
  v.section("SimulatedImu", "Errors of the simulated IMU");
  v.value("rate_hz", o.rate_hz, kRate, "readings per second");
  v.value("gyro_noise_density", o.gyro_noise_density, kNotNegative, "white, [rad/s/sqrt(Hz)]");
  v.value("acc_noise_density", o.acc_noise_density, kNotNegative, "white, [m/s^2/sqrt(Hz)]");
  v.value("gyro_random_walk", o.gyro_random_walk, kNotNegative, "of the bias, [rad/s^2/sqrt(Hz)]");
  v.value("acc_random_walk", o.acc_random_walk, kNotNegative, "of the bias, [m/s^3/sqrt(Hz)]");
  v.value("initial_bias_gyro", o.initial_bias_gyro, kNotNegative,
          "standard deviation of the first bias per axis [rad/s]");
  v.value("initial_bias_acc", o.initial_bias_acc, kNotNegative,
          "standard deviation of the first bias per axis [m/s^2]");
  v.value("scale_error", o.scale_error, kShare, "standard deviation of the gain's error per axis");
  v.value("misalignment_rad", o.misalignment_rad, kShare,
          "standard deviation per axis of the angle between gyro and body");
  v.value("saturation_gyro_radps", o.saturation_gyro_radps, kNotNegative, "rates are clipped here");
  v.value("saturation_acc_mps2", o.saturation_acc_mps2, kNotNegative,
          "accelerations are clipped here");
  v.value("dropped_share", o.dropped_share, kShare, "share of the readings that are lost");
  v.value("gravity_mps2", o.gravity_mps2, {0.0, 100.0}, "gravity along -z of the world");
  v.value("seed", o.seed, kSeed, "of all these errors");
}

void describe(OptionVisitor& v, TrackSimulationOptions& o) {
  v.section("SimulatedTracks", "Feature tracks without images");
  v.value("rate_hz", o.rate_hz, kRate, "images per second");
  v.value("phase_s", o.phase_s, kNotNegative, "of the first image after the first IMU reading");
  v.value("max_tracks", o.max_tracks, {1, 10000}, "tracks at a time");
  v.value("min_distance_px", o.min_distance_px, {1.0, 1000.0}, "between a new track and others");
  v.value("mean_track_images", o.mean_track_images, {1.0, 1e6},
          "mean length of a track that stays in view");
  v.value("weak_share", o.weak_share, kShare, "share of the corners that are lost soon");
  v.value("weak_track_images", o.weak_track_images, {1.0, 1e6}, "mean length of their tracks");
  v.value("noise_px", o.noise_px, kNotNegative, "white noise per axis");
  v.value("offset_px", o.offset_px, kNotNegative, "error per axis that stays along a track");
  v.value("drift_px", o.drift_px, kNotNegative,
          "random walk along a track per axis and square root of images");
  v.value("rest_noise", o.rest_noise, kShare, "factor of the white noise when nothing moves");
  v.value("outlier_share", o.outlier_share, kShare, "share of the tracks that slide off");
  v.value("outlier_px", o.outlier_px, kNotNegative, "how fast they slide, per image");
  v.value("room_margin_m", o.room_margin_m, {0.1, 1000.0}, "the room around the path");
  v.value("wall_density", o.wall_density, kNotNegative, "points per m^2 of wall");
  v.value("free_share", o.free_share, {0.0, 100.0}, "free-standing points per point of a wall");
  v.value("min_depth_m", o.min_depth_m, {0.01, 1000.0}, "nearer points are not seen");
  v.value("max_distance_m", o.max_distance_m, {0.1, 1e6}, "farther points are not seen");
  v.value("blackout_s", o.blackout_s, 0, "from to, from to ...: dark images");
  v.value("blind_s", o.blind_s, 0, "from to, from to ...: hardly any texture");
  v.value("seed", o.seed, kSeed, "of points, noise and losses");
}

void describe(OptionVisitor& v, RangeSimulationOptions& o) {
  v.section("SimulatedRanges", "Ranges to anchors");
  v.value("anchor_m", o.anchor_m, 0, "x y z per anchor in the world");
  v.value("anchor_id", o.anchor_id, 0, "one per anchor; without: 0 1 2 ...");
  v.value("lever_arm_m", o.lever_arm_m, 3, "antenna in the body");
  v.value("rate_hz", o.rate_hz, kRate, "ranges per second and anchor");
  v.value("jitter", o.jitter, {0.0, 0.49}, "of the stamps, in periods to either side");
  v.value("sigma_m", o.sigma_m, kNotNegative, "white noise");
  v.value("correlated_sigma_m", o.correlated_sigma_m, kNotNegative, "noise that stays for a while");
  v.value("correlated_s", o.correlated_s, {1e-3, 1e6}, "its time constant");
  v.value("bias_m", o.bias_m, {-100.0, 100.0}, "added to all ranges");
  v.value("bias_curve", o.bias_curve, 0, "distance bias, distance bias ... [m], linear in between");
  v.value("nlos_share", o.nlos_share, kShare, "share of the ranges without line of sight");
  v.value("nlos_min_m", o.nlos_min_m, kNotNegative, "how much longer they are at least");
  v.value("nlos_max_m", o.nlos_max_m, kNotNegative, "how much longer they are at most");
  v.value("nlos_burst_s", o.nlos_burst_s, kNotNegative,
          "mean length of a stretch without line of sight; 0 = every range by itself");
  v.value("outage_s", o.outage_s, 0, "from to, from to ...: no ranges");
  v.value("dropped_share", o.dropped_share, kShare, "share of the ranges that are lost");
  v.value("max_distance_m", o.max_distance_m, kNotNegative, "no ranges beyond");
  v.value("max_solid_m", o.max_solid_m, kNotNegative,
          "no ranges through more of the scene's boxes");
  v.value("differences", o.differences,
          "differences of ranges (TDoA) instead: each anchor against the one before it");
  v.value("jump", o.jump, 0, "anchor's index, time [s], x y z: the anchor is moved there");
  v.value("seed", o.seed, kSeed, "of all these errors");
}

void describe(OptionVisitor& v, TeamRangeOptions& o) {
  v.section("SimulatedTeam", "Ranges between robots, and what each tells the other with them");
  v.value("peer_rate_hz", o.peer_rate_hz, {0.0, 1000.0}, "ranges per second and pair; 0 = none");
  v.value("anchor_known_s", o.anchor_known_s, kNotNegative,
          "a robot tells of anchors from then on");
  v.value("anchor_sigma_m", o.anchor_sigma_m, kNotNegative,
          "how well it knows their positions, per axis");
}

void describe(OptionVisitor& v, OdometrySimulationOptions& o) {
  v.section("SimulatedOdometry", "Poses of a device with odometry of its own");
  v.value("rate_hz", o.rate_hz, kRate, "poses per second");
  v.value("scale_error", o.scale_error, {-0.9, 10.0}, "of all distances");
  v.value("scale_wander", o.scale_wander, kShare, "standard deviation of a part that wanders");
  v.value("scale_wander_s", o.scale_wander_s, {1e-3, 1e6}, "its time constant");
  v.value("yaw_drift_radps", o.yaw_drift_radps, {-10.0, 10.0}, "constant drift of the yaw");
  v.value("yaw_walk", o.yaw_walk, kNotNegative, "random walk of the yaw [rad/sqrt(s)]");
  v.value("position_walk", o.position_walk, kNotNegative,
          "random walk of the position [m/sqrt(s)]");
  v.value("position_noise_m", o.position_noise_m, kNotNegative, "white, on every pose");
  v.value("attitude_noise_rad", o.attitude_noise_rad, kNotNegative, "white, on every pose");
  v.value("seed", o.seed, kSeed, "of all these errors");
}

}  // namespace vir::simulation
