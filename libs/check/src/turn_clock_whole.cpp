#include "turn_clock_whole.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

using initialization::ImageTurn;
using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat5 = Eigen::Matrix<double, 5, 5>;
using Jacobian = Eigen::Matrix<double, 3, 5>;

constexpr double kMostOffsetS = 0.2, kOffsetStepS = 0.02;  // looked for, to both sides
constexpr double kRateStep = 0.003;
constexpr std::size_t kFewest = 40, kCoarse = 150;  // turns; so many for the first look
constexpr double kDifferenceS = 0.002;              // for derivatives
constexpr int kRounds = 10, kBlocks = 6;

struct Solution {
  double offset_s = 0, rate = 0;
  Vec3 bias = Vec3::Zero();
};

class Whole {
 public:
  Whole(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& readings, const Mat3& R_B_C,
        TimeNs origin)
      : turns_(turns), readings_(readings), R_C_B_(R_B_C.transpose()), origin_(origin) {}

  /// Mean rate by the gyro while a turn was, in the camera's axes [rad/s].
  bool gyroAt(const ImageTurn& turn, double offset_s, double rate, Vec3* out) const {
    const auto moved = [&](TimeNs t) {
      return t + fromSeconds(offset_s + rate * toSeconds(t - origin_));
    };
    Vec3 gyro;
    if (!readings_.meanGyro(moved(turn.t0), moved(turn.t1), &gyro)) return false;
    *out = R_C_B_ * gyro;
    return true;
  }

  /// Squared difference of images and gyro per turn, the bias being free; of some turns.
  double roughCost(double offset_s, double rate) const {
    const std::size_t step = std::max<std::size_t>(1, turns_.size() / kCoarse);
    Vec3 sum = Vec3::Zero();
    double squared = 0;
    std::size_t n = 0, asked = 0;
    for (std::size_t i = 0; i < turns_.size(); i += step) {
      ++asked;
      Vec3 gyro;
      if (!gyroAt(turns_[i], offset_s, rate, &gyro)) continue;
      const Vec3 r = gyro - turns_[i].rate_C;
      sum += r;
      squared += r.squaredNorm();
      ++n;
    }
    if (10 * n < 6 * asked || n < 8) return 1e30;
    return (squared - sum.squaredNorm() / static_cast<double>(n)) / static_cast<double>(n);
  }

  /// Offset and rate to begin with; rates up to `most_rate`.
  Solution roughly(double most_rate) const {
    Solution best;
    double least = 1e30;
    for (double rate = -most_rate; rate < most_rate + 1e-9; rate += kRateStep) {
      for (double o = -kMostOffsetS; o < kMostOffsetS + 1e-9; o += kOffsetStepS) {
        const double cost = roughCost(o, rate);
        if (cost >= least) continue;
        least = cost;
        best = {o, rate, Vec3::Zero()};
      }
    }
    return best;
  }

  /// What a turn leaves, and how that changes with offset, rate and bias.
  bool residual(const ImageTurn& turn, const Solution& s, Vec3* r, Jacobian* J) const {
    Vec3 here, before, after;
    if (!gyroAt(turn, s.offset_s, s.rate, &here) ||
        !gyroAt(turn, s.offset_s - kDifferenceS, s.rate, &before) ||
        !gyroAt(turn, s.offset_s + kDifferenceS, s.rate, &after)) {
      return false;
    }
    *r = here - s.bias - turn.rate_C;
    J->col(0) = (after - before) / (2 * kDifferenceS);
    J->col(1) = J->col(0) * toSeconds((turn.t0 + turn.t1) / 2 - origin_);
    J->rightCols<3>() = -Mat3::Identity();
    return true;
  }

  struct Fit {
    Solution at;
    double cost = 0, unexplained = 0;  ///< robust, per turn
    double rate_sigma = 0;  ///< as if all turns were independent and noise their only fault
    std::size_t turns = 0;
  };

  /// Robust least squares from there, without the turns of block `without` of kBlocks; -1: with
  /// all.
  std::optional<Fit> refined(const Solution& start, bool with_rate, int without) const {
    Fit out;
    out.at = start;
    double scale = 0;
    for (int round = 0; round <= kRounds; ++round) {
      std::vector<Vec3> residuals;
      std::vector<Jacobian> jacobians;
      for (std::size_t i = 0; i < turns_.size(); ++i) {
        if (static_cast<int>(i * kBlocks / turns_.size()) == without) continue;
        Vec3 r;
        Jacobian J;
        if (!residual(turns_[i], out.at, &r, &J)) continue;
        if (!with_rate) J.col(1).setZero();
        residuals.push_back(r);
        jacobians.push_back(J);
      }
      out.turns = residuals.size();
      if (out.turns < kFewest / 2) return std::nullopt;
      std::vector<double> sizes;
      for (const Vec3& r : residuals) sizes.push_back(r.norm());
      // Fixed after some rounds, so that the cost is one of a kind.
      if (round < 4) scale = std::max(1e-3, 2 * medianInPlace(&sizes));
      Mat5 H = Mat5::Zero();
      Vec5 g = Vec5::Zero();
      double squared = 0, weights = 0;
      out.cost = 0;
      for (std::size_t k = 0; k < residuals.size(); ++k) {
        const double relative = residuals[k].squaredNorm() / (scale * scale);
        const double w = 1 / (1 + relative);
        H += w * jacobians[k].transpose() * jacobians[k];
        g += w * jacobians[k].transpose() * residuals[k];
        squared += w * residuals[k].squaredNorm();
        weights += w;
        out.cost += std::log1p(relative);
      }
      out.cost *= scale * scale / static_cast<double>(out.turns);
      if (!with_rate) H(1, 1) = 1;
      const Eigen::LDLT<Mat5> solver(H);
      if (round == kRounds) {
        const double variance = squared / std::max(1.0, 3 * weights - 5);
        out.rate_sigma = std::sqrt(std::max(0.0, variance * solver.solve(Vec5::Unit(1).eval())(1)));
        break;
      }
      const Vec5 step = solver.solve(g);
      if (!step.allFinite()) return std::nullopt;
      out.at.offset_s -= std::clamp(step(0), -0.02, 0.02);
      if (with_rate) out.at.rate -= std::clamp(step(1), -0.003, 0.003);
      out.at.bias -= step.tail<3>();
    }
    return out;
  }

  double variation() const {
    Vec3 mean = Vec3::Zero();
    for (const ImageTurn& t : turns_) mean += t.rate_C / static_cast<double>(turns_.size());
    double out = 0;
    for (const ImageTurn& t : turns_) out += (t.rate_C - mean).squaredNorm();
    return out / static_cast<double>(turns_.size());
  }

  /// How far the rate moves where a part of the recording is left out: what is wrong in one place
  /// only, and noise that hangs together, show there.
  double spreadOfRate(const Fit& all) const {
    std::vector<double> rates;
    for (int block = 0; block < kBlocks; ++block) {
      const auto fit = refined(all.at, true, block);
      if (!fit) return 1;
      rates.push_back(fit->at.rate);
    }
    double mean = 0, sum = 0;
    for (const double r : rates) mean += r / kBlocks;
    for (const double r : rates) sum += (r - mean) * (r - mean);
    return std::sqrt(sum * (kBlocks - 1) / kBlocks);
  }

 private:
  const std::vector<ImageTurn>& turns_;
  const imu::ImuBuffer& readings_;
  const Mat3 R_C_B_;
  const TimeNs origin_;
};

/// How many times the same time is in the turns.
double overlap(const std::vector<ImageTurn>& turns) {
  double sum = 0;
  for (const ImageTurn& turn : turns) sum += toSeconds(turn.t1 - turn.t0);
  return std::max(1.0, sum / std::max(1e-9, toSeconds(turns.back().t1 - turns.front().t0)));
}

}  // namespace

std::optional<WholeClock> fitWhole(const std::vector<ImageTurn>& turns,
                                   const imu::ImuBuffer& readings, const Mat3& R_B_C,
                                   TimeNs origin) {
  if (turns.size() < kFewest) return std::nullopt;
  const Whole whole(turns, readings, R_B_C, origin);
  const auto with = whole.refined(whole.roughly(kMostRate), true, -1);
  const auto without = whole.refined(whole.roughly(0), false, -1);
  if (!with || !without) return std::nullopt;
  WholeClock out;
  out.offset_s = with->at.offset_s;
  out.rate = with->at.rate;
  out.gyro_bias = R_B_C * with->at.bias;
  out.explained = 1 - with->cost / std::max(1e-12, whole.variation());
  out.against_none = with->cost / std::max(1e-12, without->cost);
  out.rate_sigma =
      std::max(with->rate_sigma * std::sqrt(overlap(turns)), whole.spreadOfRate(*with));
  return out;
}

}  // namespace vir::check
