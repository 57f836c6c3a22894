#include "vir/check/imu_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "force_axes.h"
#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

/// Times the noise that is allowed for. The quietest moments of good recordings have 0.3 to 0.6.
constexpr double kNoisier = 5;

constexpr double kGravity = 9.80665;
constexpr TimeNs kBlock = 250'000'000;
constexpr std::size_t kMostInBlock = 20000;           // faster is no IMU, but a wrong stamp
constexpr double kSpikeSteps = 30, kSpikeSizes = 20;  // times the usual step, and the usual size
constexpr std::size_t kFewest = 8;                    // blocks, to say anything
constexpr double kMovingRate = 0.05;                  // [rad/s]
constexpr double kMovingShare = 0.03;                 // of gravity
/// Nothing with a camera on it turns this fast for a quarter of a second in a twentieth of its
/// time: in degrees it is a brisk hand.
constexpr double kFastestRate = 10;  // [rad/s]

struct UnitOfForce {
  double at_rest;
  const char* kind;
  const char* unit;
  const char* factor;
};

Finding gravityRemoved(const std::string& label, const std::string& evidence) {
  return {Severity::unusable,
          "gravity_removed",
          label,
          "gravity has been removed from the accelerometer",
          evidence,
          "record the raw specific force (on phones: accelerometer, not linear acceleration)"};
}

/// Sizes of something that is always there, as gravity is beside what moves.
bool steady(std::vector<double> sizes) {
  std::vector<double> copy = sizes;
  return quantileInPlace(&copy, 0.1) > 0.6 * medianInPlace(&sizes);
}

}  // namespace

void ImuCheck::add(const ImuSample& s) {
  ++count_;
  if (!s.acc.allFinite() || !s.gyro.allFinite()) {
    ++not_finite_;
    return;
  }
  copies_.add(s);
  clipping_.add(s);
  if (!open_.empty() &&
      (s.t - open_.front().t >= kBlock || s.t < open_.back().t || open_.size() >= kMostInBlock)) {
    close();
  }
  open_.push_back(s);
}

/// Single readings that jump away and back, as bit errors make them.
void ImuCheck::leaveOutSpikes() {
  const std::size_t n = open_.size();
  if (n < 8) return;
  std::vector<bool> bad(n, false);
  const auto look = [&](Vec3 ImuSample::*part, double farthest) {
    std::vector<double> sizes, steps;
    for (std::size_t i = 0; i < n; ++i) {
      sizes.push_back((open_[i].*part).norm());
      if (i > 0) steps.push_back((open_[i].*part - open_[i - 1].*part).norm());
    }
    const std::vector<double> step = steps;
    const double usual = medianInPlace(&steps), size = medianInPlace(&sizes);
    const double far = std::max(kSpikeSteps * usual, kSpikeSizes * std::max(size, farthest));
    for (std::size_t i = 0; i < n; ++i) {
      // At the ends there is one step only; the next one tells whose jump it is.
      const bool in = i == 0 ? step[1] < far : step[i - 1] >= far;
      const bool back = i + 1 == n ? step[i - 2] < far : step[i] >= far;
      if (!in || !back) continue;
      bad[i] = true;
      ++spikes_;
      highest_spike_ = std::max(highest_spike_, step[i == 0 ? 0 : i - 1]);
    }
  };
  look(&ImuSample::acc, 1);
  look(&ImuSample::gyro, 0.5);
  std::vector<ImuSample> good;
  for (std::size_t i = 0; i < n; ++i) {
    if (!bad[i]) good.push_back(open_[i]);
  }
  open_ = std::move(good);
}

void ImuCheck::close() {
  leaveOutSpikes();
  const auto n = static_cast<double>(open_.size());
  if (open_.size() >= 4) {
    Block b;
    b.t = open_.front().t;
    for (const ImuSample& s : open_) {
      b.acc += s.acc / n;
      b.gyro += s.gyro / n;
    }
    for (std::size_t i = 0; i < open_.size(); ++i) {
      b.acc_spread += (open_[i].acc - b.acc).squaredNorm() / n;
      if (i == 0) continue;
      b.acc_step2 += (open_[i].acc - open_[i - 1].acc).squaredNorm() / (3 * (n - 1));
      b.gyro_step2 += (open_[i].gyro - open_[i - 1].gyro).squaredNorm() / (3 * (n - 1));
    }
    b.acc_spread = std::sqrt(b.acc_spread);
    b.dt = toSeconds(open_.back().t - open_.front().t) / (n - 1);
    blocks_.add(b);
  }
  open_.clear();
}

std::vector<ImuCheck::Block> ImuCheck::quietest() const {
  if (blocks().size() < kFewest) return {};
  std::vector<double> spread;
  for (const Block& b : blocks()) spread.push_back(b.acc_spread);
  const double limit = quantileInPlace(&spread, 0.2);
  std::vector<Block> out;
  for (const Block& b : blocks()) {
    if (b.acc_spread <= limit) out.push_back(b);
  }
  return out;
}

double ImuCheck::restMagnitude() const {
  std::vector<double> norms;
  for (const Block& b : quietest()) norms.push_back(b.acc.norm());
  return medianInPlace(&norms);
}

bool ImuCheck::columnsSwapped(std::vector<Finding>* out) const {
  // Gravity in the gyro: about 9.8 that is always there, and no such thing in the accelerometer.
  std::vector<double> gyro, acc;
  for (const Block& b : blocks()) {
    gyro.push_back(b.gyro.norm());
    acc.push_back(b.acc.norm());
  }
  const bool always = steady(gyro);
  const double g = medianInPlace(&gyro), a = medianInPlace(&acc);
  const auto isGravity = [](double v) { return v > 0.85 * kGravity && v < 1.15 * kGravity; };
  if (!isGravity(g) || isGravity(a) || (a > 0.5 * kGravity && !always)) return false;
  out->push_back(
      {Severity::unusable, "imu_columns_swapped", label_,
       "gyro and accelerometer columns are swapped",
       "gravity is in the gyro: median |gyro| " + num(g) + ", median |accelerometer| " + num(a),
       "name the columns in a header (timestamp,ax,ay,az,gx,gy,gz), or reorder them; where a "
       "header "
       "names them its names are exchanged"});
  return true;
}

void ImuCheck::checkGravity(std::vector<Finding>* out) const {
  const double a = restMagnitude();
  if (a > 0.88 * kGravity && a < 1.12 * kGravity) return;
  const std::string evidence =
      "|a| is " + num(a, 4) + " in the quietest moments, 9.81 at rest is right";
  static const UnitOfForce units[] = {{1, "acc_in_g", "g", "9.80665"},
                                      {1000, "acc_in_mg", "mg", "0.00980665"},
                                      {980.665, "acc_in_cm", "cm/s2", "0.01"}};
  std::vector<double> sizes;
  for (const Block& b : blocks()) sizes.push_back(b.acc.norm());
  // What is left without gravity comes and goes, and its size may well be 1 m/s^2.
  if (a < 0.3 * kGravity && !steady(sizes)) {
    out->push_back(gravityRemoved(label_, evidence));
    return;
  }
  // Gravity in mg and in cm/s^2 is nearly the same number: the nearer one it is.
  const UnitOfForce& u = *std::min_element(
      std::begin(units), std::end(units), [a](const UnitOfForce& x, const UnitOfForce& y) {
        return std::abs(std::log(a / x.at_rest)) < std::abs(std::log(a / y.at_rest));
      });
  if (a > 0.88 * u.at_rest && a < 1.12 * u.at_rest) {
    const bool either = u.at_rest > 900;
    out->push_back({Severity::unusable, u.kind, label_,
                    std::string("the accelerometer is in ") + u.unit + ", not in m/s^2",
                    evidence + (either ? "; 980.7 in cm/s^2, 1000 in mg: the nearer is taken" : ""),
                    "import with --set " + std::string(kDriver) + ".acc_unit=" + u.unit +
                        ", or multiply it by " + u.factor});
    return;
  }
  if (a < 0.3 * kGravity) {
    out->push_back(gravityRemoved(label_, evidence));
    return;
  }
  const bool far = a < 0.7 * kGravity || a > 1.4 * kGravity;
  out->push_back({far ? Severity::unusable : Severity::doubtful, "acc_scale", label_,
                  "the accelerometer has a wrong scale or unit", evidence,
                  "give m/s^2; raw counts must be multiplied by the range over the resolution"});
}

void ImuCheck::checkRates(std::vector<Finding>* out) const {
  std::vector<double> rates;
  for (const Block& b : blocks()) rates.push_back(b.gyro.norm());
  const double fast = quantileInPlace(&rates, 0.95);
  if (fast < kFastestRate) return;
  const bool degrees = fast < 57.3 * kFastestRate;
  out->push_back({Severity::unusable, degrees ? "gyro_in_deg" : "gyro_scale", label_,
                  degrees ? "the gyro is in deg/s, not in rad/s"
                          : "the gyro is in mdeg/s or raw counts, not in rad/s",
                  "it turns at " + num(fast) +
                      " rad/s for a quarter of a second, in a twentieth of "
                      "the time",
                  degrees ? kDegreesRemedy : kMillidegreesRemedy});
}

void ImuCheck::checkAccelerometer(std::vector<Finding>* out) const {
  std::vector<Finding> unit;
  checkGravity(&unit);
  const bool known = unit.empty() || unit[0].kind == "acc_scale";
  const auto clipped = clipping_.finding(ImuClipping::Sensor::accelerometer, label_,
                                         known ? "m/s^2" : "in its unit");
  if (clipped) out->push_back(*clipped);
  // Where it is cut off below gravity, that is what is wrong with its size.
  if (!clipped || !known) out->insert(out->end(), unit.begin(), unit.end());
}

void ImuCheck::checkGyro(std::vector<Finding>* out) const {
  std::vector<Finding> unit;
  checkRates(&unit);
  const auto clipped =
      clipping_.finding(ImuClipping::Sensor::gyro, label_, unit.empty() ? "rad/s" : "in its unit");
  if (clipped) out->push_back(*clipped);
  out->insert(out->end(), unit.begin(), unit.end());
}

std::optional<bool> ImuCheck::moves(TimeNs from, TimeNs to) const {
  Vec3 gyro_low = Vec3::Constant(1e300), gyro_high = -gyro_low;
  Vec3 acc_low = gyro_low, acc_high = gyro_high;
  int n = 0;
  for (const Block& b : blocks()) {
    if (b.t < from || b.t + kBlock > to) continue;
    ++n;
    gyro_low = gyro_low.cwiseMin(b.gyro);
    gyro_high = gyro_high.cwiseMax(b.gyro);
    acc_low = acc_low.cwiseMin(b.acc);
    acc_high = acc_high.cwiseMax(b.acc);
  }
  if (n < 2) return std::nullopt;
  // Of means over a quarter of a second, so that neither noise, vibration nor a bias is motion.
  return (gyro_high - gyro_low).maxCoeff() > kMovingRate ||
         (acc_high - acc_low).maxCoeff() > kMovingShare * restMagnitude();
}

bool ImuCheck::forceAxesWrong(const Vec3& gyro_bias, std::vector<Finding>* out) const {
  // What stands still says nothing of axes: what is left of a bias would turn gravity.
  if (!blocks().empty() && !moves(blocks().front().t, blocks().back().t + kBlock).value_or(true)) {
    return false;
  }
  std::vector<ForceAndTurn> parts;
  for (const Block& b : blocks()) parts.push_back({b.t, b.gyro - gyro_bias, b.acc});
  const ForceAxes axes = forceAxes(parts);
  if (!axes.wrong && !axes.doubtful) return false;
  out->push_back({axes.wrong ? Severity::unusable : Severity::doubtful, "acc_axes", label_,
                  "the accelerometer's axes are not the gyro's: two are exchanged, or some have "
                  "the wrong sign",
                  "turned with the gyro, gravity would wander: as it is " +
                      num(100 * axes.as_is, 2) + " % of it averages out in 4 s, with other axes " +
                      num(100 * axes.best, 2) + " %",
                  "check order and signs of the accelerometer's columns against the gyro's"});
  return true;
}

void ImuCheck::checkUp(const Mounting& m, std::vector<Finding>* out) const {
  const int stretches = m.force.with + m.force.against, sign = m.force.sign();
  if (sign < 0) {
    out->push_back(
        {Severity::unusable, "acc_negated", label_,
         "the accelerometer is negated: at rest it must point up",
         "in " + std::to_string(m.force.against) + " of " + std::to_string(stretches) +
             " stretches of 1.5 s what " + m.camera +
             " sees would lie behind it, were the force as it is",
         "import with --set " + std::string(kDriver) + ".acc_unit=-m/s2 (-g where it is in g)"});
    return;
  }
  Vec3 mean = Vec3::Zero();
  for (const Block& b : blocks()) mean += b.acc.normalized();
  const double constant = mean.norm() / static_cast<double>(blocks().size());
  if (constant < 0.8) return;  // carried about any way up
  // Up, as the camera sees it: y is down, z forward.
  const Vec3 up_C = m.R_B_C.transpose() * mean.normalized();
  const bool upside_down = up_C.y() > 0.6, skyward = up_C.z() > 0.8;
  if (!upside_down && !skyward) return;
  const std::string how = upside_down ? "upside down" : "looking up";
  const std::string evidence = "by the accelerometer and its pose on the IMU, " + m.camera +
                               " has up at (" + num(up_C.x(), 2) + ", " + num(up_C.y(), 2) + ", " +
                               num(up_C.z(), 2) + ") in x right, y down, z forward";
  if (sign > 0 && !m.as_given) return;
  if (sign > 0) {
    out->push_back({Severity::note, "camera_upside_down", m.camera, "is mounted " + how,
                    evidence + "; the images move as the accelerometer says", ""});
    return;
  }
  out->push_back({Severity::doubtful, "acc_negated", label_,
                  "the accelerometer is negated (at rest it must point up), or the camera is "
                  "mounted " +
                      how,
                  evidence,
                  "import with --set " + std::string(kDriver) +
                      ".acc_unit=-m/s2 (-g where it is in g); nothing to do if the camera is "
                      "mounted so"});
}

void ImuCheck::noteNoise(const std::optional<imu::ImuNoise>& given,
                         std::vector<Finding>* out) const {
  std::vector<double> acc, gyro;
  for (const Block& b : quietest()) {
    // White noise of sigma has steps of variance 2 sigma^2; a density is sigma times sqrt(dt).
    acc.push_back(std::sqrt(b.acc_step2 / 2 * b.dt));
    gyro.push_back(std::sqrt(b.gyro_step2 / 2 * b.dt));
  }
  if (acc.empty()) return;
  const double a = medianInPlace(&acc), g = medianInPlace(&gyro);
  Finding f{Severity::note,
            "imu_noise",
            label_,
            "noise as seen in the quietest moments",
            "gyro " + num(g) + " rad/s/sqrt(Hz), accelerometer " + num(a) + " m/s^2/sqrt(Hz)",
            ""};
  if (given) {
    f.evidence += "; given " + num(given->gyro_noise_density) + " and " +
                  num(given->acc_noise_density) + ", times " + num(given->noise_scale);
    const double gyro_given = given->gyro_noise_density * given->noise_scale;
    const double acc_given = given->acc_noise_density * given->noise_scale;
    // In motion vibrations are in it, so only what is seen and not allowed for is worth a word.
    if (g > kNoisier * gyro_given || a > kNoisier * acc_given) {
      f.severity = Severity::doubtful;
      f.what = "is far noisier than the densities given";
      f.remedy = "set [Imu] gyro_noise_density = " + num(std::max(g, given->gyro_noise_density)) +
                 ", acc_noise_density = " + num(std::max(a, given->acc_noise_density));
    }
  }
  out->push_back(f);
}

std::vector<Finding> ImuCheck::findings(const std::optional<imu::ImuNoise>& given,
                                        const std::optional<Mounting>& mounting, bool gyro_trusted,
                                        const Vec3& gyro_bias) const {
  std::vector<Finding> out;
  if (not_finite_ > 0) {
    out.push_back({not_finite_ * 100 > count_ ? Severity::doubtful : Severity::note, "not_finite",
                   label_, "readings are no numbers",
                   std::to_string(not_finite_) + " of " + std::to_string(count_), ""});
  }
  if (spikes_ > 0) {
    out.push_back({Severity::doubtful, "imu_spikes", label_, "single readings jump away and back",
                   std::to_string(spikes_) + " of " + std::to_string(count_) + ", by up to " +
                       num(highest_spike_),
                   "leave them out before importing; look for bit errors on the way"});
  }
  if (blocks().size() < kFewest) return out;
  if (columnsSwapped(&out)) return out;
  checkAccelerometer(&out);
  const std::size_t before_rates = out.size();
  checkGyro(&out);
  const bool turns_right = gyro_trusted && out.size() == before_rates;
  const bool axes = turns_right && forceAxesWrong(gyro_bias, &out);
  if (mounting && !axes) checkUp(*mounting, &out);
  if (worst(out) == Severity::note) noteNoise(given, &out);
  return out;
}

}  // namespace vir::check
