/// What ties anchors to one another, whatever the path: a survey, and ranges between them.
#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "long_window_state.h"

namespace vir::window {

/// Where the survey lies in W is no state: for every place of its anchors there is one that fits
/// best, and it is eliminated in closed form.
LevelFit LongWindow::Impl::surveyFit() const {
  std::vector<LevelPair> pairs;
  for (const SurveyTie& tie : survey) {
    const auto a = anchors.find(tie.anchor);
    if (a == anchors.end()) continue;
    pairs.push_back({tie.p_S, a->second.position(), 1 / (tie.sigma_m * tie.sigma_m)});
  }
  return fitLevel(pairs);
}

/// Residuals w^1/2 (Rz(yaw) a + t - s), of which yaw and t are eliminated. With the turn about the
/// weighted centre the two are independent of each other, and at their optimum have no gradient.
void LongWindow::Impl::addSurvey(Frontal* f) const {
  const LevelFit fit = surveyFit();
  if (!(fit.weight > 0)) return;
  const Mat3 R = rotZ(fit.T_A_B.yaw_rad);
  struct Held {
    int at;
    double weight;
    Vec3 swing;
  };
  std::vector<Held> held;
  for (const SurveyTie& tie : survey) {
    const int index = anchorIndex(tie.anchor);
    if (index < 0) continue;
    const Vec3 p_W = anchors.at(tie.anchor).position();
    const double weight = 1 / (tie.sigma_m * tie.sigma_m);
    held.push_back({f->anchorOffset(index), weight, fit.swing(p_W)});
    f->b.segment<3>(held.back().at) += weight * (R.transpose() * (fit.T_A_B * p_W - tie.p_S));
    f->H.block<3, 3>(held.back().at, held.back().at) += weight * Mat3::Identity();
  }
  for (const Held& i : held) {
    for (const Held& j : held) {
      Mat3 known = Mat3::Identity() / fit.weight;
      if (fit.turn_known) known += i.swing * j.swing.transpose() / fit.turn;
      f->H.block<3, 3>(i.at, j.at) -= i.weight * j.weight * (R.transpose() * known * R);
    }
  }
}

factors::RangePrediction LongWindow::Impl::predictDistance(const AnchorDistance& d,
                                                           const AnchorNode& a,
                                                           const AnchorNode& b) const {
  return factors::predictRange(a.position(), b.position(), 0, d.range_m);
}

void LongWindow::Impl::addDistances(Frontal* f) const {
  for (const AnchorDistance& d : distances) {
    const int first = anchorIndex(d.first), second = anchorIndex(d.second);
    if (first < 0 || second < 0 || first == second) continue;
    const factors::RangePrediction p =
        predictDistance(d, anchors.at(d.first), anchors.at(d.second));
    // As in the factors of ranges: value is predicted - measured.
    const ranging::RobustRange::Value v = options.robust.evaluate(-p.value_m / d.sigma_m);
    const Eigen::Matrix<double, 1, 1> e(-v.e);
    const Eigen::Matrix<double, 1, 3, Eigen::RowMajor> J =
        v.de_dr / d.sigma_m * p.direction.transpose();
    const Eigen::Matrix<double, 1, 3, Eigen::RowMajor> minus = -J;
    f->add<1, 3, 3>(e, J, f->anchorOffset(first), minus, f->anchorOffset(second));
  }
}

double LongWindow::Impl::costOfTies() const {
  double sum = surveyFit().cost;
  for (const AnchorDistance& d : distances) {
    const auto a = anchors.find(d.first), b = anchors.find(d.second);
    if (a == anchors.end() || b == anchors.end() || a == b) continue;
    const double r = -predictDistance(d, a->second, b->second).value_m / d.sigma_m;
    sum += 2 * options.robust.loss(r);
  }
  return sum;
}

void LongWindow::setSurvey(std::vector<SurveyTie> ties) { impl_->survey = std::move(ties); }
void LongWindow::setAnchorDistances(std::vector<AnchorDistance> distances) {
  impl_->distances = std::move(distances);
}
const std::vector<SurveyTie>& LongWindow::survey() const { return impl_->survey; }
LevelFit LongWindow::surveyFit() const { return impl_->surveyFit(); }

}  // namespace vir::window
