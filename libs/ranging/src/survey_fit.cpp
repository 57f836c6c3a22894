#include "survey_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace vir::ranging {
namespace {

/// Below this distance the direction to the anchor is not defined [m].
constexpr double kZeroDistance = 1e-9;
/// The survey's world is within 100 km: keeps the equations solvable where ranges say nothing.
constexpr double kWeakest = 1e-10;
/// Of what is not estimated.
constexpr double kNothing = 1e-6;

}  // namespace

SurveyData SurveyData::thinned(std::size_t count) const {
  std::vector<std::size_t> total, seen;
  for (const SurveyRange& r : ranges) {
    if (total.size() <= r.anchor) total.resize(r.anchor + 1, 0);
    ++total[r.anchor];
  }
  seen.resize(total.size(), 0);
  SurveyData out;
  out.end_W = end_W;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const std::size_t a = ranges[i].anchor, k = seen[a]++;
    const std::size_t keep = std::min(count, total[a]);
    if (k * keep / total[a] == (k + 1) * keep / total[a]) continue;
    out.ranges.push_back(ranges[i]);
    out.drift.push_back(drift[i]);
  }
  return out;
}

SurveyState SurveyFitter::startAt(double yaw, const Vec3& end_S) const {
  SurveyState x;
  x.yaw = yaw;
  x.end_S = end_S;
  x.anchors.assign(survey_->size(), Vec4::Zero());
  return x;
}

double SurveyFitter::build(const SurveyState& x, System* system) const {
  double cost = 0;
  const Mat3 R = rotZ(x.yaw);
  const double longer = std::exp(x.log_scale), weigh = 1 / worth_;
  if (system) system->anchors.assign(survey_->size(), AnchorPart());
  for (const SurveyRange& range : data_->ranges) {
    const Vec3 way = longer * (R * (range.p_W - data_->end_W));
    const Vec4& own = x.anchors[range.anchor];
    const Vec3 v = x.end_S + way - (*survey_)[range.anchor].p_S - own.head<3>();
    const double d = v.norm(), inverse_sigma = 1 / (range.sigma_m * scale_);
    const RobustRange::Value value =
        options_->robust.evaluate((range.range_m - d - own[3]) * inverse_sigma);
    cost += weigh * 0.5 * value.e * value.e;
    if (!system) continue;
    const Vec3 u = d > kZeroDistance ? Vec3(v / d) : Vec3::Zero();
    Vec5 J;
    J << u.y() * way.x() - u.x() * way.y(), u, u.dot(way);
    J *= -inverse_sigma;
    Vec4 Ja;
    Ja << inverse_sigma * u, -inverse_sigma;
    const double w = weigh * value.influence();
    const double r = (range.range_m - d - own[3]) * inverse_sigma;
    AnchorPart& part = system->anchors[range.anchor];
    system->H.noalias() += w * J * J.transpose();
    system->g += w * r * J;
    part.H.noalias() += w * Ja * Ja.transpose();
    part.cross.noalias() += w * J * Ja.transpose();
    part.g += w * r * Ja;
  }
  const double sigma_s = std::max(options_->scale_sigma, kNothing);
  cost += 0.5 * x.log_scale * x.log_scale / (sigma_s * sigma_s);
  if (system) {
    system->H(4, 4) += 1 / (sigma_s * sigma_s);
    system->H.diagonal().head<4>().array() += kWeakest;
    system->g[4] += x.log_scale / (sigma_s * sigma_s);
  }
  const double sigma_b = std::max(options_->bias_sigma_m, kNothing);
  for (std::size_t a = 0; a < survey_->size(); ++a) {
    const double sigma = std::max((*survey_)[a].sigma_m, kNothing);
    Vec4 information;
    information << Vec3::Constant(1 / (sigma * sigma)), 1 / (sigma_b * sigma_b);
    const Vec4 pull = information.cwiseProduct(x.anchors[a]);
    cost += 0.5 * x.anchors[a].dot(pull);
    if (!system) continue;
    system->anchors[a].H.diagonal() += information;
    system->anchors[a].g += pull;
  }
  return cost;
}

double SurveyFitter::cost(const SurveyState& x) const { return build(x, nullptr); }

/// Each anchor follows what is common: linear in their number.
SurveyState SurveyFitter::step(const SurveyState& x, const System& system, double damping) const {
  Mat5 H = system.H;
  Vec5 g = system.g;
  H.diagonal() *= 1 + damping;
  std::vector<Mat4> inverse(system.anchors.size());
  for (std::size_t a = 0; a < system.anchors.size(); ++a) {
    const AnchorPart& part = system.anchors[a];
    Mat4 own = part.H;
    own.diagonal() *= 1 + damping;
    inverse[a] = own.inverse();
    const Eigen::Matrix<double, 5, 4> W = part.cross * inverse[a];
    H -= W * part.cross.transpose();
    g -= W * part.g;
  }
  const Vec5 d = -H.ldlt().solve(g);
  SurveyState out = x;
  out.yaw += d[0];
  out.end_S += d.segment<3>(1);
  out.log_scale += d[4];
  for (std::size_t a = 0; a < system.anchors.size(); ++a) {
    const AnchorPart& part = system.anchors[a];
    out.anchors[a] -= inverse[a] * (part.g + part.cross.transpose() * d);
  }
  return out;
}

SurveyState SurveyFitter::minimise(SurveyState x, int iterations, double* cost) const {
  System system;
  double now = build(x, &system), damping = 1e-4;
  for (int k = 0; k < iterations && damping < 1e8; ++k) {
    const SurveyState next = step(x, system, damping);
    const bool finite = next.end_S.allFinite() && std::isfinite(next.yaw) &&
                        std::isfinite(next.log_scale) && std::abs(next.log_scale) < 1;
    System then_system;
    const double then = finite ? build(next, &then_system) : now + 1;
    if (!(then <= now)) {
      damping = std::max(damping * 10, 1e-3);
      continue;
    }
    const double gain = now - then;
    x = next;
    now = then;
    system = then_system;
    damping = std::max(damping * 0.1, 1e-9);
    if (gain < 1e-7 * std::min(now, 1.0)) break;
  }
  if (cost) *cost = now;
  return x;
}

std::vector<double> SurveyFitter::residuals(const SurveyState& x) const {
  std::vector<double> out;
  const Mat3 R = rotZ(x.yaw);
  const double longer = std::exp(x.log_scale);
  for (const SurveyRange& r : data_->ranges) {
    const Vec4& own = x.anchors[r.anchor];
    const Vec3 p_S = x.end_S + longer * (R * (r.p_W - data_->end_W));
    const double d = (p_S - (*survey_)[r.anchor].p_S - own.head<3>()).norm();
    out.push_back((r.range_m - d - own[3]) / r.sigma_m);
  }
  return out;
}

Eigen::Matrix4d SurveyFitter::covariance(const SurveyState& x) const {
  System system;
  build(x, &system);
  Mat5 H = system.H;
  for (const AnchorPart& part : system.anchors) {
    H -= part.cross * part.H.inverse() * part.cross.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat5> eigen(0.5 * (H + H.transpose()));
  const Vec5 inverse = eigen.eigenvalues().cwiseMax(kWeakest).cwiseInverse();
  const Mat5 all = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  return all.topLeftCorner<4, 4>();
}

}  // namespace vir::ranging
