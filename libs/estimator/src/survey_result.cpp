/// What a survey of the anchors comes to at the end: its place, and what is wrong with it.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "range_layer_impl.h"
#include "vir/core/parse_number.h"

namespace vir::estimator {
namespace {

/// Less known than this, a component is open: [rad], [m].
constexpr double kOpenRad = 0.2, kOpenM = 1.0;
/// An anchor that is not tied and is so far from where the survey has it [m], and so many sigmas,
/// is elsewhere.
constexpr double kElsewhere = 0.3, kElsewhereSigmas = 4;
/// At most so many ids in a text.
constexpr std::size_t kMostIds = 8;

/// T_S_W by the anchors that are tied, with the covariance of (yaw, t).
struct SurveyPlace {
  LevelFit fit;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

struct TiedAnchor {
  std::uint64_t key;
  double weight;
};

/// d(yaw, t) / d(position of an anchor in W), all in one matrix; and what stays when these are
/// known.
SurveyPlace placeOf(const window::LongWindow& window) {
  SurveyPlace out;
  out.fit = window.surveyFit();
  const LevelFit& fit = out.fit;
  std::vector<TiedAnchor> tied;
  for (const window::SurveyTie& tie : window.survey()) {
    if (window.anchors().count(tie.anchor) == 0) continue;
    tied.push_back({tie.anchor, 1 / (tie.sigma_m * tie.sigma_m)});
  }
  if (tied.empty()) return out;
  const Mat3 R = rotZ(fit.T_A_B.yaw_rad);
  const Vec3 c = R * fit.centre_B, turned(-c.y(), c.x(), 0);
  const auto n = static_cast<Eigen::Index>(3 * tied.size());
  Eigen::MatrixXd per_anchor = Eigen::MatrixXd::Zero(4, n);
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < tied.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Vec3 swing = fit.swing(window.anchors().at(tied[i].key).position());
    Eigen::RowVector3d yaw = Eigen::RowVector3d::Zero();
    if (fit.turn_known) yaw = -tied[i].weight / fit.turn * (swing.transpose() * R);
    per_anchor.block<1, 3>(0, at) = yaw;
    per_anchor.block<3, 3>(1, at) = -tied[i].weight / fit.weight * R - turned * yaw;
    for (std::size_t j = 0; j < tied.size(); ++j) {
      const int a = window.columnOf(tied[i].key), b = window.columnOf(tied[j].key);
      if (a < 0 || b < 0) continue;
      joint.block<3, 3>(at, static_cast<Eigen::Index>(3 * j)) =
          window.jointCovariance().block<3, 3>(a, b);
    }
  }
  Eigen::Matrix4d rest = Eigen::Matrix4d::Zero();
  rest(0, 0) = fit.turn_known ? 1 / fit.turn : 0;
  rest.block<3, 3>(1, 1) = Mat3::Identity() / fit.weight + rest(0, 0) * turned * turned.transpose();
  rest.block<3, 1>(1, 0) = -rest(0, 0) * turned;
  rest.block<1, 3>(0, 1) = rest.block<3, 1>(1, 0).transpose();
  out.covariance = rest + per_anchor * joint * per_anchor.transpose();
  return out;
}

std::string listOf(const std::vector<std::uint64_t>& ids) {
  std::string text;
  for (std::size_t i = 0; i < ids.size() && i < kMostIds; ++i) {
    text += (i > 0 ? ", " : "") + std::to_string(ids[i]);
  }
  return text + (ids.size() > kMostIds ? ", ..." : "");
}

/// Ids that devices print in hexadecimal, written without 0x, are taken for decimal ones.
std::string hexHint(const std::vector<std::uint64_t>& survey,
                    const std::vector<std::uint64_t>& heard) {
  for (const std::uint64_t id : survey) {
    std::uint64_t as_hex = 0;
    if (!parseNumber(std::to_string(id), &as_hex, 16)) continue;
    if (std::find(heard.begin(), heard.end(), as_hex) == heard.end()) continue;
    return "; read in hexadecimal they do: write 0x" + std::to_string(id);
  }
  return {};
}

void noteOpen(const Eigen::Matrix4d& covariance, bool turn_known, SurveyFit* out) {
  const char* const names[] = {"yaw", "x", "y", "z"};
  const bool turns = turn_known && std::sqrt(covariance(0, 0)) < kOpenRad;
  for (int i = 0; i < 4; ++i) {
    const bool wide = std::sqrt(std::max(0.0, covariance(i, i))) > (i == 0 ? kOpenRad : kOpenM);
    if (wide || (!turns && i < 3)) out->open.push_back(names[i]);
  }
}

std::string elsewhereText(const Anchor& a, const Vec3& p_S, const Vec3& given) {
  char text[200];
  std::snprintf(text, sizeof text,
                "anchor %llu is at (%.2f, %.2f, %.2f) in the survey's frame, %.2f m from where the "
                "survey has it: it was moved, or measured wrongly",
                static_cast<unsigned long long>(a.id), p_S.x(), p_S.y(), p_S.z(),
                (p_S - given).norm());
  return text;
}

/// Ids that are in only one of survey and ranges.
void noteIds(const std::vector<std::uint64_t>& survey, const std::vector<std::uint64_t>& heard,
             SurveyFit* out) {
  const auto notIn = [](const std::vector<std::uint64_t>& some,
                        const std::vector<std::uint64_t>& others) {
    std::vector<std::uint64_t> left;
    for (const std::uint64_t id : some) {
      if (std::find(others.begin(), others.end(), id) == others.end()) left.push_back(id);
    }
    return left;
  };
  const std::vector<std::uint64_t> unheard = notIn(survey, heard), unknown = notIn(heard, survey);
  if (unheard.size() == survey.size()) {
    out->reason = heard.empty()
                      ? "no range has been heard"
                      : "none of its ids (" + listOf(survey) + ") is among those heard (" +
                            listOf(heard) + ")" + hexHint(survey, heard);
    return;
  }
  if (!unheard.empty()) {
    out->findings.push_back("never heard: " + listOf(unheard) + hexHint(unheard, unknown));
  }
  if (!unknown.empty()) {
    out->findings.push_back("heard, but not in the survey: " + listOf(unknown) +
                            "; estimated as any other anchor");
  }
  if (survey.size() - unheard.size() > 1) return;
  out->reason = "only one of its anchors has been heard: the turn about it stays open";
  out->open = {"yaw", "x", "y"};
}

}  // namespace

/// Where each of its anchors is in S, and which are elsewhere although nothing spoke against them
/// when it was matched.
void RangeLayer::Impl::addSurveyed(const std::vector<Anchor>& anchors, SurveyFit* out) const {
  for (std::size_t i = 0; i < survey.given.size(); ++i) {
    SurveyedResult r;
    r.given = survey.given[i];
    const auto track = tracks.find(r.given.id);
    r.heard = track != tracks.end();
    r.used = r.heard && track->second.tied;
    const auto a = std::find_if(anchors.begin(), anchors.end(),
                                [&](const Anchor& x) { return x.id == r.given.id; });
    if (survey.found && a != anchors.end() && a->has_position) {
      const Vec3& given = survey.match.survey[i].p_S;
      r.p_S = out->T_S_W * a->p_W;
      const double sigma = std::sqrt(std::max(0.0, a->covariance.trace()));
      const bool told =
          !track->second.left_survey &&
          std::any_of(survey.match.findings.begin(), survey.match.findings.end(),
                      [&](const auto& f) {
                        return f.fault == ranging::SurveyFault::elsewhere && f.first == i;
                      });
      const bool off = (*r.p_S - given).norm() > std::max(kElsewhere, kElsewhereSigmas * sigma);
      if (!r.used && !told && off) out->findings.push_back(elsewhereText(*a, *r.p_S, given));
    }
    out->anchors.push_back(std::move(r));
  }
}

std::optional<SurveyFit> RangeLayer::survey() const {
  const Impl& s = *impl_;
  const SurveyLife& life = s.survey;
  if (life.given.empty()) return std::nullopt;
  SurveyFit out;
  out.status = life.match.status;
  out.reason = life.match.reason;
  for (const ranging::SurveyFinding& f : life.match.findings) {
    const auto track = s.tracks.find(life.given[f.first].id);
    const bool later = track != s.tracks.end() && track->second.left_survey;
    if (!later) out.findings.push_back(ranging::describe(f, life.given));
  }
  std::vector<std::uint64_t> surveyed, heard;
  for (const SurveyedAnchor& g : life.given) surveyed.push_back(g.id);
  for (const auto& [id, a] : s.tracks) heard.push_back(id);
  noteIds(surveyed, heard, &out);
  if (life.found) {
    const SurveyPlace place = placeOf(*s.window);
    out.T_S_W = place.fit.T_A_B;
    out.covariance = place.covariance;
    if (life.match.other) {
      const double half = 0.5 * (life.match.other->t_m.z() - life.match.T_S_W.t_m.z());
      out.covariance(3, 3) += half * half;
    }
    noteOpen(out.covariance, place.fit.turn_known, &out);
  }
  s.addSurveyed(anchors(), &out);
  return out;
}

}  // namespace vir::estimator
