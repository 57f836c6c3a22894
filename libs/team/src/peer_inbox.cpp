#include "vir/team/peer_inbox.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "vir/core/time_bounds.h"
#include "vir/geometry/finite_pose.h"

namespace vir::team {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMostSenders = 32;
constexpr TimeNs kLatest = 2'000'000'000;           // that a range waits
constexpr TimeNs kAhead = 500'000'000;              // clocks that agree are not so far apart
constexpr double kFarthest = 1e6;                   // [m] from where a robot began
constexpr double kMostSigma = 1e3, kMostTurn = 10;  // [m], [rad]
constexpr double kLeastSigma = 1e-3;                // [m] nobody knows better
constexpr double kLongestAntenna = 100;             // [m]
constexpr double kSilence = 1;  // [s] of a robot before another one may have its number

double limited(double value) { return std::max(value, kLeastSigma * kLeastSigma); }

/// Finite, symmetric as sent, and no variance below 0 in any direction.
bool isCovariance(const Eigen::MatrixXd& C) {
  if (!(C.diagonal().minCoeff() >= 0)) return false;
  // Scaled, so that metres and radians are judged alike.
  const Eigen::VectorXd scale =
      C.diagonal().unaryExpr([](double v) { return v > 0 ? 1 / std::sqrt(v) : 0.0; });
  const Eigen::MatrixXd rho = scale.asDiagonal() * C * scale.asDiagonal();
  if (!rho.allFinite()) return false;
  // What belongs to a variance of 0 must be 0 itself.
  for (int i = 0; i < C.rows(); ++i) {
    if (C(i, i) == 0 && C.row(i).cwiseAbs().maxCoeff() > 0) return false;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rho, Eigen::EigenvaluesOnly);
  // Sent as float.
  return solver.eigenvalues()[0] > -1e-4;
}

bool isPosition(const Vec3& p, const Mat3& C) {
  return p.cwiseAbs().maxCoeff() < kFarthest && C.diagonal().maxCoeff() < kMostSigma * kMostSigma &&
         isCovariance(C);
}

bool finite(const PeerReport& r) {
  return isFinite(r.T_W_B) && std::abs(r.T_W_B.q.norm() - 1) < 0.01 && r.covariance.allFinite() &&
         r.p_B_U.allFinite();
}

bool sensible(const PeerReport& r) {
  return isPosition(r.T_W_B.p, r.covariance.topLeftCorner<3, 3>()) &&
         r.covariance.diagonal().tail<3>().maxCoeff() < kMostTurn * kMostTurn &&
         isCovariance(r.covariance) && r.p_B_U.norm() < kLongestAntenna;
}

Mat3 floored(Mat3 C) {
  for (int i = 0; i < 3; ++i) C(i, i) = limited(C(i, i));
  return C;
}

bool isTransform(const WorldTransform& T) {
  return std::isfinite(T.yaw_rad) && std::abs(T.yaw_rad) < kMostTurn && T.t_m.allFinite() &&
         T.t_m.cwiseAbs().maxCoeff() < kFarthest;
}

/// Without what is none.
TeamTold sensible(const TeamTold& told, TimeNs t) {
  TeamTold out;
  if (told.frame && isTransform(told.frame->T_C_own) && isStamp(told.frame->founded) &&
      isStamp(told.frame->held_since) && told.frame->founded <= t + kAhead &&
      told.frame->held_since <= t + kAhead) {
    out.frame = told.frame;
  }
  for (const ToldTransform& one : told.transforms) {
    if (out.transforms.size() >= kMostToldTransforms) break;
    const auto& C = one.covariance;
    const bool good = isTransform(one.T_own_from) && C.allFinite() &&
                      C.diagonal().maxCoeff() < kMostSigma * kMostSigma && isCovariance(C);
    if (good) out.transforms.push_back(one);
  }
  return out;
}

HeardReport contentOf(const PeerReport& r, int world, std::uint32_t own_number) {
  const int robot = static_cast<std::int32_t>(r.robot);
  HeardReport out;
  out.pose = {robot,
              world,
              r.t,
              {r.T_W_B.q.normalized(), r.T_W_B.p},
              floored(r.covariance.topLeftCorner<3, 3>()),
              r.p_B_U};
  out.world = {r.robot, r.session, r.segment};
  if (r.team) out.team = sensible(*r.team, r.t);
  for (const auto& [id, sent] : r.anchors) {
    if (out.anchors.size() >= kMostReportedAnchors) break;
    if (!sent.p_W.allFinite() || !sent.covariance.allFinite()) continue;
    if (!isPosition(sent.p_W, sent.covariance)) continue;
    out.anchors.push_back({robot, id, {r.t, sent.p_W, floored(sent.covariance)}});
  }
  for (const Range& range : r.ranges) {
    if (out.ranges.size() >= kMostReportedRanges) break;
    const bool to_us = range.anchor == own_number;
    const bool good = std::isfinite(range.range_m) && range.range_m > 0 &&
                      range.range_m < kFarthest && std::isfinite(range.sigma_m) &&
                      range.sigma_m > 0 && range.sigma_m < kMostSigma && isStamp(range.t) &&
                      range.t <= r.t + kAhead && range.t >= r.t - kLatest;
    if (!to_us || !good) continue;
    Range own = range;
    own.anchor = r.robot;
    out.ranges.push_back(own);
  }
  return out;
}

}  // namespace

const char* name(ReportDecision decision) {
  switch (decision) {
    case ReportDecision::accepted:
      return "accepted";
    case ReportDecision::other_version:
      return "other_version";
    case ReportDecision::own_number:
      return "own_number";
    case ReportDecision::not_finite:
      return "not_finite";
    case ReportDecision::absurd:
      return "absurd";
    case ReportDecision::other_clock:
      return "other_clock";
    case ReportDecision::late:
      return "late";
    case ReportDecision::repeated:
      return "repeated";
    case ReportDecision::old_world:
      return "old_world";
    case ReportDecision::same_number:
      return "same_number";
    case ReportDecision::too_many_robots:
      break;
  }
  return "too_many_robots";
}

std::optional<HeardReport> PeerInbox::add(const PeerReport& report, std::optional<TimeNs> own_time,
                                          double arrival_s) {
  const ReportDecision decision = decide(report, own_time, arrival_s);
  ++counts_[static_cast<std::size_t>(decision)];
  if (decision != ReportDecision::accepted) {
    tell(report, decision, own_time);
    return std::nullopt;
  }
  return contentOf(report, senders_.at(report.robot).world, own_number_);
}

ReportDecision PeerInbox::decide(const PeerReport& r, std::optional<TimeNs> own_time,
                                 double arrival_s) {
  if (r.version != kPeerReportVersion) return ReportDecision::other_version;
  if (r.robot == own_number_) return ReportDecision::own_number;
  if (!finite(r)) return ReportDecision::not_finite;
  if (!sensible(r)) return ReportDecision::absurd;
  if (!own_time || !isStamp(r.t) || r.t > *own_time + kAhead) return ReportDecision::other_clock;
  // Robots that are switched on one after the other hear of each other's past.
  if (r.t < *own_time - kLatest) return ReportDecision::late;
  return decideSender(r, arrival_s);
}

ReportDecision PeerInbox::decideSender(const PeerReport& r, double arrival_s) {
  auto known = senders_.find(r.robot);
  if (known == senders_.end()) {
    if (senders_.size() >= kMostSenders) return ReportDecision::too_many_robots;
    known = senders_.emplace(r.robot, Sender()).first;
    known->second.session = r.session;
    known->second.segment = r.segment;
    known->second.newest = r.sequence;
    known->second.seen.set(0);
    known->second.heard_s = arrival_s;
    return ReportDecision::accepted;
  }
  Sender& s = known->second;
  if (r.session != s.session) {
    const auto end = s.left.begin() + static_cast<long>(std::min(s.left_count, s.left.size()));
    if (std::find(s.left.begin(), end, r.session) != end) return ReportDecision::old_world;
    if (arrival_s < s.heard_s + kSilence) return ReportDecision::same_number;
    s.left[s.left_count++ % s.left.size()] = s.session;
    s.session = r.session;
    s.segment = r.segment;
    s.newest = r.sequence;
    s.seen.reset();
    s.seen.set(0);
    ++s.world;
    s.heard_s = arrival_s;
    return ReportDecision::accepted;
  }
  if (r.segment < s.segment) return ReportDecision::old_world;
  const ReportDecision decision = decideSequence(r, &s);
  if (decision != ReportDecision::accepted) return decision;
  s.world += r.segment > s.segment ? 1 : 0;
  s.segment = r.segment;
  s.heard_s = arrival_s;
  return decision;
}

ReportDecision PeerInbox::decideSequence(const PeerReport& r, Sender* s) {
  // What counts up for years may begin anew at 0.
  const auto ahead = static_cast<std::int32_t>(r.sequence - s->newest);
  if (ahead > 0) {
    lost_ += ahead - 1;
    s->seen <<= static_cast<std::size_t>(ahead);
    s->seen.set(0);
    s->newest = r.sequence;
    return ReportDecision::accepted;
  }
  const auto back = static_cast<std::size_t>(-static_cast<std::int64_t>(ahead));
  if (back >= kWindow) return ReportDecision::late;
  if (s->seen.test(back)) return ReportDecision::repeated;
  s->seen.set(back);
  ++reordered_;
  if (lost_ > 0) --lost_;
  return ReportDecision::accepted;
}

void PeerInbox::tell(const PeerReport& r, ReportDecision decision, std::optional<TimeNs> own_time) {
  const std::string robot = "robot " + std::to_string(r.robot);
  const auto once = [&](bool* told, const std::string& text) {
    if (!*told) vir::log(log_, LogLevel::warning, text);
    *told = true;
  };
  const auto known = senders_.find(r.robot);
  switch (decision) {
    case ReportDecision::own_number:
      once(&told_own_number_,
           "another robot of the team says that it is number " + std::to_string(r.robot) +
               ", which this one is: give each its own (Dds.robot, or own_id of the "
               "radio)");
      break;
    case ReportDecision::other_version:
      once(&told_version_, robot + " speaks version " + std::to_string(r.version) +
                               " of the team's messages, this one " +
                               std::to_string(kPeerReportVersion) + ": not listened to");
      break;
    case ReportDecision::same_number:
      once(&known->second.told_number, "two robots of the team say that they are number " +
                                           std::to_string(r.robot) +
                                           ": the one that was heard first is listened to (give "
                                           "each its own Dds.robot, or own_id of the radio)");
      break;
    case ReportDecision::other_clock:
    case ReportDecision::late: {
      if (!own_time || !isStamp(r.t)) break;
      const double ahead_s = toSeconds(timeBetween(*own_time, r.t));
      char text[160];
      std::snprintf(text, sizeof text,
                    "what robot %u tells is stamped %.1f s %s: not listened to (set the clocks of "
                    "both by NTP or PTP)",
                    r.robot, std::abs(ahead_s), ahead_s > 0 ? "ahead" : "behind");
      once(&told_clock_, text);
      break;
    }
    default:
      break;
  }
}

std::vector<std::pair<std::string, long>> PeerInbox::counters() const {
  std::vector<std::pair<std::string, long>> out;
  for (std::size_t i = 0; i < kReportDecisions; ++i) {
    if (counts_[i] > 0) out.emplace_back(name(static_cast<ReportDecision>(i)), counts_[i]);
  }
  if (reordered_ > 0) out.emplace_back("reordered", reordered_);
  if (lost_ > 0) out.emplace_back("lost", lost_);
  return out;
}

}  // namespace vir::team
