#include "turn_clock.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "text.h"
#include "turn_clock_whole.h"

namespace vir::check {
namespace {

using initialization::TurnCorrelation;

constexpr double kReachS = 0.2;  // offsets of the clocks looked for, to both sides
constexpr double kTurnS = 0.09;  // over less than this, noise makes turns of steps aside
constexpr double kLongestTurnS = 0.3;
constexpr double kOffsetS = 0.004;  // that no estimate of a window needs to be told
/// Of a short recording less, so that there are enough to make out a line.
constexpr double kPieceS = 4, kShortPieceS = 2, kShortS = 16;
constexpr double kFewestInPieceHz = 7.5;
constexpr int kFewestPieces = 3;
constexpr double kLeastSigmaS = 2e-4;  // of a piece, whatever it says itself
/// Of the rate by all turns together: what the images must explain of the gyro, and what it leaves
/// at most of the misfit without a rate, with 4 and with 2 sigmas. MH01 and V1_02, whole and in
/// pieces of 8 s, leave 0.987 and more at 1.1 sigmas and less.
constexpr double kWholeExplained = 0.8, kWholeLeft = 0.9, kWholeHardlyLeft = 0.6;
/// Quartz differs by 1e-4 at the very worst, and an estimate follows that.
constexpr double kRate = 3e-4;

/// Turns over longer times, put together from images that follow each other.
std::vector<initialization::ImageTurn> joined(const std::vector<ImageTurn>& seen) {
  std::vector<initialization::ImageTurn> turns;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Mat3 R = Mat3::Identity();
    std::size_t k = i;
    for (;; ++k) {
      R = R * expSO3(seen[k].rotation_C);
      const bool linked = k + 1 < seen.size() && seen[k + 1].t0 == seen[k].t1;
      if (toSeconds(seen[k].t1 - seen[i].t0) >= kTurnS || !linked) break;
    }
    const double span = toSeconds(seen[k].t1 - seen[i].t0);
    if (span < kTurnS || span > kLongestTurnS) continue;
    initialization::ImageTurn turn;
    turn.t0 = seen[i].t0;
    turn.t1 = seen[k].t1;
    turn.rate_C = logSO3(R) / span;
    // All alike; the correlation finds out how good they are.
    turn.information = Mat3::Identity() / (0.02 * 0.02);
    turns.push_back(turn);
  }
  return turns;
}

/// Offsets along the recording, and the line through them.
struct Piece {
  double t_s, offset_s, weight;
};

struct Line {
  double offset_s = 0, rate = 0, rate_sigma = 1;
  double at(double t_s) const { return offset_s + rate * t_s; }
};

Line lineThrough(const std::vector<Piece>& pieces) {
  double w = 0, t = 0, o = 0, tt = 0, to = 0;
  for (const Piece& p : pieces) {
    w += p.weight;
    t += p.weight * p.t_s;
    o += p.weight * p.offset_s;
  }
  t /= w;
  o /= w;
  for (const Piece& p : pieces) {
    tt += p.weight * (p.t_s - t) * (p.t_s - t);
    to += p.weight * (p.t_s - t) * (p.offset_s - o);
  }
  Line out{o, 0, 1};
  if (pieces.size() < 2 || !(tt > 0)) return out;
  out.rate = to / tt;
  out.offset_s = o - out.rate * t;
  double chi2 = 0;
  for (const Piece& p : pieces) chi2 += p.weight * std::pow(p.offset_s - out.at(p.t_s), 2);
  const double freedom = std::max<double>(1, static_cast<double>(pieces.size()) - 2);
  out.rate_sigma = std::sqrt(std::max(1.0, chi2 / freedom) / tt);
  return out;
}

/// Where pieces so far point to. A line through fewer than three would follow their noise.
Line expectedAfter(const std::vector<Piece>& pieces, double rate) {
  if (pieces.size() >= 3) return lineThrough(pieces);
  Line out{0, rate, 1};
  if (!pieces.empty()) out.offset_s = pieces.back().offset_s - rate * pieces.back().t_s;
  return out;
}

/// An offset for each piece of some seconds, searched around where those before it point to; the
/// first ones with this rate.
std::vector<Piece> offsetsAlong(const std::vector<initialization::ImageTurn>& turns,
                                const imu::ImuBuffer& readings, const Mat3& R_B_C, TimeNs origin,
                                double rate, double piece_s) {
  std::vector<Piece> out;
  for (std::size_t i = 0; i < turns.size();) {
    const TimeNs start = turns[i].t0;
    std::size_t end = i;
    while (end < turns.size() && toSeconds(turns[end].t0 - start) < piece_s) ++end;
    std::vector<initialization::ImageTurn> piece(turns.begin() + static_cast<std::ptrdiff_t>(i),
                                                 turns.begin() + static_cast<std::ptrdiff_t>(end));
    i = end;
    if (static_cast<double>(piece.size()) < kFewestInPieceHz * piece_s) continue;
    const double t_s = toSeconds((piece.front().t0 + piece.back().t1) / 2 - origin);
    const Line expected = expectedAfter(out, rate);
    for (initialization::ImageTurn& turn : piece) {
      turn.t0 += fromSeconds(expected.at(toSeconds(turn.t0 - origin)));
      turn.t1 += fromSeconds(expected.at(toSeconds(turn.t1 - origin)));
    }
    const auto found =
        initialization::correlateTurns(piece, readings, Quat(R_B_C), {kReachS, 0.004});
    if (!found.ok) continue;
    const double sigma = std::max(found.sigma_s, kLeastSigmaS);
    out.push_back({t_s, expected.at(t_s) + found.offset_s, 1 / (sigma * sigma)});
  }
  return out;
}

void fitRate(const std::vector<initialization::ImageTurn>& turns, const imu::ImuBuffer& readings,
             const Mat3& R_B_C, ClockFit* fit) {
  std::vector<Piece> pieces;
  const double span_s = toSeconds(turns.back().t1 - fit->origin);
  const double piece_s = span_s < kShortS ? kShortPieceS : kPieceS;
  // Clocks that run far apart blur the first pieces.
  for (const double rate : {0., 0.02, -0.02, 0.01, -0.01}) {
    pieces = offsetsAlong(turns, readings, R_B_C, fit->origin, rate, piece_s);
    if (static_cast<int>(pieces.size()) >= kFewestPieces) break;
  }
  fit->pieces = static_cast<int>(pieces.size());
  if (fit->pieces < kFewestPieces) return;
  const Line line = lineThrough(pieces);
  fit->rate = line.rate;
  fit->rate_sigma = line.rate_sigma;
  fit->first_s = pieces.front().t_s;
  fit->last_s = pieces.back().t_s;
  fit->first_offset_s = line.at(fit->first_s);
  fit->last_offset_s = line.at(fit->last_s);
  fit->runs_apart = std::abs(line.rate) > kRate && std::abs(line.rate) > 4 * line.rate_sigma;
  fit->offset_s = line.offset_s;
}

/// By all turns together where pieces do not tell: the finer the pieces, the less a slow and smooth
/// turning says in each.
void fitRateOfAll(const std::vector<initialization::ImageTurn>& turns,
                  const imu::ImuBuffer& readings, const Mat3& R_B_C, ClockFit* fit) {
  const auto whole = fitWhole(turns, readings, R_B_C, fit->origin);
  if (!whole) return;
  const double sigmas = std::abs(whole->rate) / whole->rate_sigma;
  const bool sure = (sigmas > 4 && whole->against_none < kWholeLeft) ||
                    (sigmas > 2 && whole->against_none < kWholeHardlyLeft);
  const bool plausible = std::abs(whole->rate) > kRate && std::abs(whole->rate) < kMostRate;
  if (!sure || !plausible || whole->explained < kWholeExplained) return;
  fit->runs_apart = true;
  fit->rate = whole->rate;
  fit->rate_sigma = whole->rate_sigma;
  fit->offset_s = whole->offset_s;
  fit->pieces = 0;
  fit->first_s = 0;
  fit->last_s = toSeconds(turns.back().t1 - fit->origin);
  fit->first_offset_s = whole->offset_s;
  fit->last_offset_s = whole->offset_s + whole->rate * fit->last_s;
}

void take(const TurnCorrelation& found, ClockFit* fit) {
  fit->ok = found.ok;
  fit->sigma_s = found.sigma_s;
  fit->turns = found.turns;
  fit->gyro_bias = found.gyro_bias;
}

/// Rates that are set: 20, 25, 30, 200, 208 Hz, ... A clock that runs fast makes others of them.
bool isRound(double hz) {
  for (const double r : {5., 10., 15., 20., 25., 30., 50., 60., 90., 100., 120., 125., 200., 250.,
                         400., 500., 800., 1000.}) {
    if (std::abs(hz / r - 1) < 2e-4) return true;
  }
  return false;
}

}  // namespace

TimeNs ClockFit::onImuClock(TimeNs image) const {
  return image + fromSeconds(offset_s + (runs_apart ? rate * toSeconds(image - origin) : 0));
}

ClockFit fitClock(const std::vector<ImageTurn>& turns_seen, const imu::ImuBuffer& readings,
                  const Mat3& R_B_C) {
  ClockFit fit;
  std::vector<initialization::ImageTurn> turns = joined(turns_seen);
  if (turns.empty()) return fit;
  fit.origin = turns.front().t0;
  fitRate(turns, readings, R_B_C, &fit);
  if (!fit.runs_apart) fitRateOfAll(turns, readings, R_B_C, &fit);
  if (!fit.runs_apart) {
    const auto found =
        initialization::correlateTurns(turns, readings, Quat(R_B_C), {kReachS, 0.004});
    take(found, &fit);
    fit.offset_s = found.offset_s;
    return fit;
  }
  for (initialization::ImageTurn& turn : turns) {
    turn.t0 = fit.onImuClock(turn.t0);
    turn.t1 = fit.onImuClock(turn.t1);
  }
  const auto found = initialization::correlateTurns(turns, readings, Quat(R_B_C), {0.05, 0.004});
  take(found, &fit);
  fit.offset_s += found.ok ? found.offset_s : 0;
  return fit;
}

std::vector<Finding> clockFindings(const ClockFit& fit, double given_s, double image_hz,
                                   double imu_hz, const std::string& camera_label,
                                   const std::string& imu_label) {
  if (fit.runs_apart) {
    const bool images_round = isRound(image_hz), imu_round = isRound(imu_hz);
    // Fast: it counts more seconds than the other.
    const bool imu_fast = fit.rate > 0;
    const bool blame_imu = images_round && !imu_round, blame_images = imu_round && !images_round;
    const std::string percent = num(100 * std::abs(fit.rate), 3) + " %";
    const std::string what =
        blame_imu ? "its clock runs " + percent + (imu_fast ? " fast" : " slow") +
                        " against that of the images"
        : blame_images ? "its clock runs " + percent + (imu_fast ? " slow" : " fast") +
                             " against that of the IMU"
                       : "its clock and the IMU's run at different rates: the IMU's is " + percent +
                             (imu_fast ? " fast" : " slow") + ", or the camera's " +
                             (imu_fast ? "slow" : "fast");
    const double scale = blame_imu ? 1 / (1 + fit.rate) : 1 + fit.rate;
    return {
        {Severity::doubtful, "clock_rate", blame_imu ? imu_label : camera_label, what,
         "gyro and images agree with " + num(1e3 * fit.first_offset_s) + " ms at " +
             num(fit.first_s) + " s and " + num(1e3 * fit.last_offset_s) + " ms at " +
             num(fit.last_s) + " s added to the stamps of the images (" +
             (fit.pieces > 0 ? std::to_string(fit.pieces) + " pieces, " : "all turns together, ") +
             num(1e3 * fit.rate) + " +- " + num(1e3 * fit.rate_sigma, 2) +
             " ms/s); images come at " + num(image_hz, 5) + " Hz, the IMU at " + num(imu_hz, 5) +
             " Hz by their stamps",
         "stamp both by one clock; or multiply the times since the beginning of " +
             (blame_imu ? imu_label : camera_label) + " by " + num(scale, 6)}};
  }
  if (!fit.ok) return {};
  const double apart = fit.offset_s - given_s;
  const std::string by = num(1e3 * std::abs(apart)) + " ms";
  const std::string evidence =
      "gyro and turning of the images agree best with " + num(1e3 * fit.offset_s) + " +- " +
      num(1e3 * fit.sigma_s, 2) + " ms added to the stamps of the images (" +
      std::to_string(fit.turns) + " turns); given " + num(1e3 * given_s) + " ms";
  if (std::abs(apart) < kOffsetS || std::abs(apart) < 4 * fit.sigma_s) {
    return {{Severity::note, "time_offset", camera_label, "its clock against the gyro's as found",
             evidence, ""}};
  }
  return {{Severity::doubtful, "time_offset", camera_label,
           std::string("its images are stamped ") + by + (apart < 0 ? " late" : " early"), evidence,
           "give it: timeshift_cam_imu in the calibration, or --set Camera.time_offset_s=" +
               num(fit.offset_s) + "; `calibrate = online` finds the rest"}};
}

}  // namespace vir::check
