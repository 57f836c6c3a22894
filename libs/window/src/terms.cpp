#include "window_state.h"

namespace vir::window {

template <typename Factor, typename... Args>
Factor& TermSet::make(Args&&... args) {
  auto p = std::make_unique<Factor>(std::forward<Args>(args)...);
  Factor& ref = *p;
  others_.push_back(std::move(p));
  return ref;
}

void TermSet::addPrior() {
  if (w_.prior.r0.size() == 0) return;
  auto& f = make<factors::LinearPriorFactor>(w_.prior);
  terms_.push_back({&f, w_.prior_blocks, 0, false, nullptr});
}

void TermSet::addLink(Frame& a, Frame& b) {
  if (!w_.calibrating()) return addFixedLink(a, b);
  addLinkTerm(make<factors::ImuCalibrationFactor>(*b.link, w_.noise.gravity_mps2), a, b,
              {w_.imu_intrinsics});
}

void TermSet::addFixedLink(Frame& a, Frame& b) {
  addLinkTerm(make<factors::ImuFactor>(*b.link, w_.noise.gravity_mps2, w_.imuIntrinsics()), a, b,
              {});
}

template <typename Factor>
void TermSet::addLinkTerm(Factor& f, Frame& a, Frame& b, std::initializer_list<double*> further) {
  if (w_.options.first_estimate_jacobians) {
    f.linearizeAt(a.linPose(), a.linSpeedBias(), b.linPose(), b.linSpeedBias());
  }
  std::vector<double*> blocks{a.pose, a.speed_bias, b.pose, b.speed_bias};
  blocks.insert(blocks.end(), further);
  terms_.push_back({&f, std::move(blocks), 0, false, nullptr});
}

void TermSet::addRest(Frame& a, Frame* before) {
  if (!a.standing) return;
  auto& f = make<factors::ZeroVelocityFactor>(w_.options.rest_sigma_v_mps);
  terms_.push_back({&f, {a.speed_bias}, 0, false, nullptr});
  if (!before || !before->standing) return;
  Eigen::Matrix<double, 6, 6> S = Eigen::Matrix<double, 6, 6>::Zero();
  S.diagonal().head<3>().setConstant(1.0 / w_.options.rest_sigma_p_m);
  S.diagonal().tail<3>().setConstant(1.0 / w_.options.rest_sigma_theta_rad);
  auto& g = make<factors::RelativePoseFactor>(Pose(), S);
  terms_.push_back({&g, {before->pose, a.pose}, 0, false, nullptr});
}

void TermSet::addLandmark(WindowLandmark& l) {
  Frame* host = l.host();
  const bool cauchy = w_.options.loss == ReprojectionLoss::cauchy;
  if (w_.calibrating()) updateCameraJacobians(w_, &l);
  auto& host_sight = w_.sight_factors.host_sights.next();
  host_sight.set(l.ray, l.sights.front().sight.weight);
  terms_.push_back({&host_sight, {l.x}, 0, false, l.x});
  for (std::size_t k = 1; k < l.sights.size(); ++k) {
    Frame* f = l.sights[k].frame;
    const int number = l.hostCamera();
    if (l.sights[k].camera != number) {
      addRigSight(l, l.sights[k]);
      continue;
    }
    const bool fej = w_.options.first_estimate_jacobians;
    const double* lin_i = fej ? host->linPose() : nullptr;
    const double* lin_j = fej ? f->linPose() : nullptr;
    if (w_.calibrating()) {
      auto& r = w_.sight_factors.calibrations.next();
      r.set(l.ray, l.sights[k].sight);
      r.linearizeAt(lin_i, lin_j);
      terms_.push_back({&r,
                        {host->pose, f->pose, w_.extrinsicOf(number), l.x, w_.parametersOf(number)},
                        w_.options.loss_scale,
                        cauchy,
                        l.x});
    } else {
      auto& r = w_.sight_factors.reprojections.next();
      r.set(l.ray, l.sights[k].sight, w_.T_B_C(number), w_.cameraVector(number));
      r.linearizeAt(lin_i, lin_j);
      terms_.push_back({&r, {host->pose, f->pose, l.x}, w_.options.loss_scale, cauchy, l.x});
    }
    ++sights_;
  }
}

void TermSet::addRigSight(WindowLandmark& l, LandmarkSight& s) {
  Frame *host = l.host(), *frame = s.frame;
  const bool same = host == frame, fej = w_.options.first_estimate_jacobians;
  auto& r = w_.sight_factors.rig_sights.next();
  const double* lin_i = fej ? host->linPose() : nullptr;
  const double* lin_j = fej ? frame->linPose() : nullptr;
  if (w_.calibrating()) {
    r.set(l.ray, s.sight, same, nullptr, lin_i, lin_j);
  } else {
    const factors::RigReprojectionFactor::Known known{w_.T_B_C(l.hostCamera()), w_.T_B_C(s.camera),
                                                      w_.cameraVector(l.hostCamera()),
                                                      w_.cameraVector(s.camera)};
    r.set(l.ray, s.sight, same, &known, lin_i, lin_j);
  }
  BlockList blocks{l.x};
  if (!same) {
    blocks.add(host->pose);
    blocks.add(frame->pose);
  }
  if (w_.calibrating()) {
    for (const int k : {l.hostCamera(), s.camera}) {
      blocks.add(w_.extrinsicOf(k));
      blocks.add(w_.parametersOf(k));
    }
  }
  const bool cauchy = w_.options.loss == ReprojectionLoss::cauchy;
  terms_.push_back({&r, std::move(blocks), w_.options.loss_scale, cauchy, l.x});
  ++sights_;
}

void TermSet::addAll() {
  w_.sight_factors.startOver();
  std::size_t sights = 0;
  for (const auto& [id, l] : w_.landmarks) sights += l.sights.size();
  terms_.reserve(sights + 4 * w_.frames.size());
  if (w_.calibrating()) noteRotations(w_);
  addPrior();
  for (std::size_t k = 0; k < w_.frames.size(); ++k) {
    Frame* before = k ? w_.frames[k - 1].get() : nullptr;
    if (before) addLink(*before, *w_.frames[k]);
    addRest(*w_.frames[k], before);
  }
  for (auto& [id, l] : w_.landmarks) {
    if (l.has_depth && l.sights.size() >= 2) addLandmark(l);
  }
}

void TermSet::addRanges() {
  LongWindow& lw = *w_.long_window;
  const NormalEquations& known = lw.eliminate();
  message_ = toPrior(known);
  std::vector<double*> blocks;
  for (const BlockRef& b : known.blocks) blocks.push_back(b.data);
  auto& f = make<factors::LinearPriorFactor>(message_);
  terms_.push_back({&f, blocks, 0, false, nullptr});
  double* const host = w_.frames.front()->pose;
  // Without a heading of O in W the window can only be turned in O.
  std::optional<Quat> q_O_B0;
  if (!lw.yawFrozen()) q_O_B0 = w_.frames.front()->T_W_B().q;
  for (auto& frame : w_.frames) {
    for (const HeldRange& r : frame->ranges) {
      AnchorNode* a = lw.anchor(r.anchor);
      if (!a) continue;
      if (r.reference) {
        addDifference(*frame, r, *a);
        continue;
      }
      if (!a->settled) {
        const RigidRange range = rigidRange(w_, *frame, r);
        rigid_ranges_.emplace_back(range.term, range.motion_O, range.lever_O);
        terms_.push_back({&rigid_ranges_.back(), {lw.headParameters(), a->x}, 0, false, nullptr});
        continue;
      }
      const factors::RangeTerm term = lw.termOf(r.anchor, r.range_m, r.sigma_m);
      const Vec3 motion = lw.options().ranges_at_own_time ? r.motion : Vec3(Vec3::Zero());
      if (frame->pose == host) {
        head_ranges_.emplace_back(term, motion, r.lever, q_O_B0);
        terms_.push_back(
            {&head_ranges_.back(), {host, lw.headParameters(), a->x}, 0, false, nullptr});
      } else {
        window_ranges_.emplace_back(term, motion, r.lever, q_O_B0);
        terms_.push_back({&window_ranges_.back(),
                          {host, frame->pose, lw.headParameters(), a->x},
                          0,
                          false,
                          nullptr});
      }
    }
  }
}

/// The short window's own geometry is far better known than a difference of ranges: rigid.
void TermSet::addDifference(const Frame& frame, const HeldRange& r, AnchorNode& a) {
  LongWindow& lw = *w_.long_window;
  AnchorNode* reference = lw.anchor(*r.reference);
  if (reference == nullptr || reference == &a) return;
  const RigidRange rigid = rigidRange(w_, frame, r);
  rigid_differences_.emplace_back(rigid.term, rigid.motion_O, rigid.lever_O);
  terms_.push_back(
      {&rigid_differences_.back(), {lw.headParameters(), reference->x, a.x}, 0, false, nullptr});
}

void TermSet::addTail(std::size_t first) {
  w_.sight_factors.startOver();
  for (std::size_t k = first; k < w_.frames.size(); ++k) {
    Frame* before = k ? w_.frames[k - 1].get() : nullptr;
    if (before) addFixedLink(*before, *w_.frames[k]);
    addRest(*w_.frames[k], before);
  }
  std::vector<Pose> T_B_C;
  for (int k = 0; k < w_.cameras(); ++k) T_B_C.push_back(w_.T_B_C(k));
  const bool cauchy = w_.options.loss == ReprojectionLoss::cauchy;
  const auto in_tail = [&](const Frame* f) {
    for (std::size_t k = first; k < w_.frames.size(); ++k) {
      if (w_.frames[k].get() == f) return true;
    }
    return false;
  };
  for (auto& [id, l] : w_.landmarks) {
    if (!l.has_depth || in_tail(l.host())) continue;
    const Vec3 p_W = landmarkInWorld(w_, l);
    for (std::size_t k = l.sights.size() - 1; k > 0 && in_tail(l.sights[k].frame); --k) {
      const factors::Sight& sight = l.sights[k].sight;
      const int number = l.sights[k].camera;
      auto& f = w_.sight_factors.point_sights.next();
      f.set(p_W, sight.bearingAt(w_.cameraVector(number)), sight.weight,
            T_B_C[static_cast<std::size_t>(number)]);
      terms_.push_back({&f, {l.sights[k].frame->pose}, w_.options.loss_scale, cauchy, nullptr});
      ++sights_;
    }
  }
}

void TermSet::addOldest(const std::vector<std::uint64_t>& ids) {
  w_.sight_factors.startOver();
  addPrior();
  addRest(*w_.frames[0], nullptr);
  if (w_.frames.size() > 1) addLink(*w_.frames[0], *w_.frames[1]);
  if (w_.calibrating()) noteRotations(w_);
  for (std::uint64_t id : ids) addLandmark(w_.landmarks.at(id));
}

void addCalibrationBlocks(WindowState& w, std::vector<BlockRef>* order) {
  if (!w.calibrating()) return;
  for (FurtherCamera& c : w.further) {
    order->push_back({c.extrinsic, 7, 0, nullptr});
    order->push_back({c.parameters, factors::kCameraParameters, 0, nullptr});
  }
  order->push_back({w.extrinsic, 7, 0, nullptr});
  order->push_back({w.camera_parameters, factors::kCameraParameters, 0, nullptr});
  order->push_back({w.imu_intrinsics, imu::kImuIntrinsicsSize, 0, nullptr});
}

std::vector<BlockRef> leadingOrder(WindowState& w, std::size_t* leading) {
  std::vector<BlockRef> out;
  *leading = w.frames.size();
  for (auto f = w.frames.rbegin(); f != w.frames.rend(); ++f) {
    out.push_back({(*f)->speed_bias, 9, 0, (*f)->linSpeedBias()});
  }
  for (auto& f : w.frames) out.push_back({f->pose, 7, 0, f->linPose()});
  addCalibrationBlocks(w, &out);
  return out;
}

std::vector<BlockRef> frameBlocks(WindowState& w, std::size_t first, std::size_t count) {
  std::vector<BlockRef> out;
  for (std::size_t k = first; k < first + count; ++k) {
    Frame& f = *w.frames[k];
    out.push_back({f.pose, 7, 0, f.linPose()});
    out.push_back({f.speed_bias, 9, 0, f.linSpeedBias()});
  }
  return out;
}

}  // namespace vir::window
