#include "cyclone/report_sample.h"

#include <algorithm>

namespace vir::dds {
namespace {

template <int N, typename Number>
void putUpper(const Eigen::Matrix<double, N, N>& C, Number* out) {
  for (int r = 0; r < N; ++r) {
    for (int c = r; c < N; ++c) *out++ = static_cast<Number>(C(r, c));
  }
}

template <int N, typename Number>
Eigen::Matrix<double, N, N> symmetric(const Number* upper) {
  Eigen::Matrix<double, N, N> C;
  for (int r = 0; r < N; ++r) {
    for (int c = r; c < N; ++c) C(r, c) = C(c, r) = static_cast<double>(*upper++);
  }
  return C;
}

void putVector(const Vec3& v, double* out) { std::copy_n(v.data(), 3, out); }
Vec3 vectorOf(const double* v) { return {v[0], v[1], v[2]}; }

vir_team_World sampleOf(const team::WorldId& w) { return {w.robot, w.session, w.segment}; }
team::WorldId worldOf(const vir_team_World& w) { return {w.robot, w.session, w.segment}; }

team::TeamTold teamOf(const vir_team_Report& s) {
  team::TeamTold told;
  if (s.frame._length > 0) {
    const vir_team_Frame& f = s.frame._buffer[0];
    told.frame =
        team::CommonFrame{worldOf(f.founder), f.founded, f.held_since, {f.yaw, vectorOf(f.offset)}};
  }
  for (std::uint32_t i = 0; i < s.transforms._length; ++i) {
    const vir_team_Transform& t = s.transforms._buffer[i];
    told.transforms.push_back(
        {worldOf(t.from), {t.yaw, vectorOf(t.offset)}, symmetric<4>(t.covariance)});
  }
  return told;
}

}  // namespace

ReportSample::ReportSample(const team::PeerReport& r) {
  sample_.version = static_cast<std::uint8_t>(r.version);
  sample_.robot = r.robot;
  sample_.session = r.session;
  sample_.segment = r.segment;
  sample_.sequence_number = r.sequence;
  sample_.stamp = r.t;
  putVector(r.T_W_B.p, sample_.position);
  std::copy_n(r.T_W_B.q.coeffs().data(), 4, sample_.orientation);
  putUpper<6>(r.covariance, sample_.covariance);
  for (int i = 0; i < 3; ++i) sample_.antenna[i] = static_cast<float>(r.p_B_U[i]);
  for (const auto& [id, sent] : r.anchors) {
    if (anchors_.size() >= team::kMostReportedAnchors) break;
    vir_team_Anchor& a = anchors_.emplace_back();
    a.id = id;
    putVector(sent.p_W, a.position);
    putUpper<3>(sent.covariance, a.covariance);
  }
  for (const Range& range : r.ranges) {
    if (ranges_.size() >= team::kMostReportedRanges) break;
    ranges_.push_back({static_cast<std::uint32_t>(range.anchor), range.t, range.range_m,
                       static_cast<float>(range.sigma_m)});
  }
  if (r.team) addTeam(*r.team);
  sample_.anchors._buffer = anchors_.data();
  sample_.anchors._length = sample_.anchors._maximum = static_cast<std::uint32_t>(anchors_.size());
  sample_.ranges._buffer = ranges_.data();
  sample_.ranges._length = sample_.ranges._maximum = static_cast<std::uint32_t>(ranges_.size());
}

void ReportSample::addTeam(const team::TeamTold& told) {
  sample_.team = true;
  if (told.frame) {
    frame_.founder = sampleOf(told.frame->founder);
    frame_.founded = told.frame->founded;
    frame_.held_since = told.frame->held_since;
    frame_.yaw = told.frame->T_C_own.yaw_rad;
    putVector(told.frame->T_C_own.t_m, frame_.offset);
    sample_.frame._buffer = &frame_;
    sample_.frame._length = sample_.frame._maximum = 1;
  }
  for (const team::ToldTransform& t : told.transforms) {
    if (transforms_.size() >= team::kMostToldTransforms) break;
    vir_team_Transform& out = transforms_.emplace_back();
    out.from = sampleOf(t.from);
    out.yaw = t.T_own_from.yaw_rad;
    putVector(t.T_own_from.t_m, out.offset);
    putUpper<4>(t.covariance, out.covariance);
  }
  sample_.transforms._buffer = transforms_.data();
  sample_.transforms._length = sample_.transforms._maximum =
      static_cast<std::uint32_t>(transforms_.size());
}

team::PeerReport reportOf(const vir_team_Report& s) {
  team::PeerReport r;
  r.version = s.version;
  r.robot = s.robot;
  r.session = s.session;
  r.segment = s.segment;
  r.sequence = s.sequence_number;
  r.t = s.stamp;
  r.T_W_B.p = vectorOf(s.position);
  std::copy_n(s.orientation, 4, r.T_W_B.q.coeffs().data());
  r.covariance = symmetric<6>(s.covariance);
  for (int i = 0; i < 3; ++i) r.p_B_U[i] = static_cast<double>(s.antenna[i]);
  for (std::uint32_t i = 0; i < s.anchors._length; ++i) {
    const vir_team_Anchor& a = s.anchors._buffer[i];
    r.anchors.emplace_back(a.id,
                           SentPosition{r.t, vectorOf(a.position), symmetric<3>(a.covariance)});
  }
  for (std::uint32_t i = 0; i < s.ranges._length; ++i) {
    const vir_team_Range& range = s.ranges._buffer[i];
    r.ranges.push_back(
        {range.stamp, range.robot, range.distance, static_cast<double>(range.sigma), Vec3::Zero()});
  }
  if (s.team) r.team = teamOf(s);
  return r;
}

}  // namespace vir::dds
