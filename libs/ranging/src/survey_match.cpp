#include "vir/ranging/survey_match.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "survey_faults.h"
#include "survey_places.h"
#include "vir/core/angles.h"

namespace vir::ranging {
namespace {

/// Two places that differ by less than this horizontally [m] and in their turn [rad] differ in
/// their height alone.
constexpr double kLevelM = 0.3, kLevelRad = 0.03;
/// Nearer than this [m] the curvature of a range is no help.
constexpr double kLeastDistance = 0.1;

std::string format(const char* pattern, double a, double b = 0) {
  char text[200];
  std::snprintf(text, sizeof text, pattern, a, b);
  return text;
}

/// Drift is the same for neighbouring ranges and does not average out: variance per axis.
double commonDrift(const SurveyData& data) {
  double drift = 0, weights = 0;
  for (std::size_t i = 0; i < data.ranges.size(); ++i) {
    const double weight = 1 / (data.ranges[i].sigma_m * data.ranges[i].sigma_m);
    drift += weight * data.drift[i];
    weights += weight;
  }
  return weights > 0 ? (drift / weights) * (drift / weights) : 0;
}

/// Of (yaw, end in S) at the best place, ranges that resemble one another taken into account.
Eigen::Matrix4d covarianceAt(const SurveyData& data, const std::vector<SurveyedAnchor>& survey,
                             const SurveyMatchOptions& options, const SurveyPlaces& places) {
  SurveyFitter fitter(&data, &survey, &options);
  fitter.setFactors(places.scale, places.worth);
  Eigen::Matrix4d covariance = fitter.covariance(places.optima.front().x);
  covariance.bottomRightCorner<3, 3>() += commonDrift(data) * Mat3::Identity();
  return covariance;
}

/// Semi-axes of the ellipsoid that count, as for a single anchor: across the line of sight an
/// offset hardly changes the range.
double neededSigma(const Mat3& covariance, double distance) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  const double largest = std::sqrt(std::max(eigen.eigenvalues()[2], 0.0));
  const double second = std::sqrt(std::max(eigen.eigenvalues()[1], 0.0));
  return std::max(second, largest * largest / std::max(distance, kLeastDistance));
}

void placeAnchors(const SurveyData& data, const SurveyState& x, const Eigen::Matrix4d& covariance,
                  double sigma_bias, const std::vector<char>& heard, SurveyMatch* match) {
  const Mat3 R = rotZ(x.yaw);
  for (std::size_t a = 0; a < match->survey.size(); ++a) {
    MatchedAnchor& m = match->anchors[a];
    const Vec3 way = R.transpose() * (match->survey[a].p_S + x.anchors[a].head<3>() - x.end_S);
    m.p_W = data.end_W + way;
    m.bias_m = x.anchors[a][3];
    Eigen::Matrix<double, 3, 4> J;
    J << Vec3(way.y(), -way.x(), 0), -R.transpose();
    const double sigma = match->survey[a].sigma_m;
    m.covariance.topLeftCorner<3, 3>() =
        J * covariance * J.transpose() + sigma * sigma * Mat3::Identity();
    m.covariance(3, 3) = sigma_bias * sigma_bias;
    if (!heard[a] || !m.used) continue;
    const double needed = neededSigma(m.covariance.topLeftCorner<3, 3>(), way.norm());
    match->needed_sigma_m = std::max(match->needed_sigma_m, needed);
  }
}

void takeTransform(const SurveyData& data, const SurveyState& x, const Eigen::Matrix4d& covariance,
                   SurveyMatch* match) {
  match->T_S_W = transformOf(data, x);
  const Vec3 turned = rotZ(x.yaw) * data.end_W;
  Eigen::Matrix4d J = Eigen::Matrix4d::Identity();
  J.block<3, 1>(1, 0) = -Vec3(-turned.y(), turned.x(), 0);
  match->covariance = J * covariance * J.transpose();
}

/// One place, several, or too uncertain a one.
void judge(const SurveyData& data, const SurveyPlaces& places, const SurveyMatchOptions& options,
           SurveyMatch* match) {
  bool elsewhere = false;
  for (std::size_t i = 1; i < places.optima.size(); ++i) {
    const SurveyState &a = places.optima[0].x, &b = places.optima[i].x;
    const bool level = (a.end_S - b.end_S).head<2>().norm() < kLevelM &&
                       std::abs(std::remainder(a.yaw - b.yaw, 2 * kPi)) < kLevelRad;
    if (level && !match->other) match->other = transformOf(data, b);
    elsewhere = elsewhere || !level;
  }
  match->status = SurveyStatus::open;
  if (elsewhere) {
    match->reason = "move sideways: the ranges fit the survey in " +
                    std::to_string(places.optima.size()) + " ways";
  } else if (match->needed_sigma_m > options.max_sigma_m) {
    match->reason =
        format("move further: the survey's place is known to %.1f m only", match->needed_sigma_m);
  } else {
    match->status = SurveyStatus::found;
  }
}

std::string idOf(const std::vector<SurveyedAnchor>& survey, std::size_t index) {
  return std::to_string(survey[index].id);
}

}  // namespace

std::string describe(const SurveyFinding& f, const std::vector<SurveyedAnchor>& survey) {
  const std::string id = idOf(survey, f.first);
  if (f.fault == SurveyFault::exchanged) {
    return "the survey has anchors " + id + " and " + idOf(survey, f.second) +
           " exchanged, by their ranges: taken as such; put their ids right";
  }
  if (f.fault == SurveyFault::unit) {
    return format(
        "the survey's numbers are no metres: the ranges fit it with 1 = %g m; taken as "
        "such; give metres",
        f.factor);
  }
  const Vec3& given = survey[f.first].p_S;
  if (!f.found_S) {
    return "anchor " + id +
           " is not where the survey has it: its ranges are too short for that; not taken from the "
           "survey; measure it again";
  }
  const Vec3 found = *f.found_S;
  char where[160];
  std::snprintf(where, sizeof where,
                " is not where the survey has it: its ranges put it at (%.2f, %.2f, %.2f), %.2f m "
                "from there",
                found.x(), found.y(), found.z(), (found - given).norm());
  return "anchor " + id + where + ": not taken from the survey; measure it again";
}

SurveyMatch matchSurvey(const std::vector<SurveyRange>& ranges,
                        const std::vector<SurveyedAnchor>& survey,
                        const SurveyMatchOptions& options) {
  SurveyMatch match;
  match.survey = survey;
  match.anchors.resize(survey.size());
  const SurveyData all = surveyData(ranges, survey.size(), options.drift_ratio);
  const std::vector<char> heard = heardIn(all, survey.size());
  if (std::count(heard.begin(), heard.end(), 1) < 2) {
    match.reason = "fewer than two of its anchors have been heard";
    return match;
  }
  if (static_cast<int>(all.ranges.size()) < options.min_ranges) {
    match.reason = format("wait: %.0f of %.0f ranges so far",
                          static_cast<double>(all.ranges.size()), options.min_ranges);
    return match;
  }
  SurveyHypothesis h = likeliest(all, survey, options);
  match.survey = h.survey;
  match.findings = h.findings;
  match.uncalibrated = h.uncalibrated;
  for (std::size_t a = 0; a < survey.size(); ++a) match.anchors[a].used = h.used[a] != 0;
  if (!believable(h)) {
    match.status = h.suspicion.empty() ? SurveyStatus::open : SurveyStatus::contradicted;
    match.reason = h.suspicion.empty() ? "the ranges do not fit the survey so far" : h.suspicion;
    return match;
  }
  SurveyMatchOptions with = options;
  with.bias_sigma_m = h.bias_sigma_m;
  const Eigen::Matrix4d covariance = covarianceAt(h.data, h.survey, with, h.places);
  const SurveyState& x = h.places.optima.front().x;
  placeAnchors(h.data, x, covariance, h.bias_sigma_m, heard, &match);
  takeTransform(h.data, x, covariance, &match);
  judge(h.data, h.places, options, &match);
  if (match.status == SurveyStatus::found && !h.undecided.empty()) {
    match.status = SurveyStatus::open;
    match.reason = "move further: the survey is right, or wrong about " + h.undecided;
  }
  return match;
}

}  // namespace vir::ranging
