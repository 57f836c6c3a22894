/// A team as it works on the air, in one process: every robot judges what it hears, follows the
/// pairs that it ranges to, and maps the team from what the others tell of theirs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "vir/core/resource_usage.h"
#include "vir/team/peer_inbox.h"
#include "vir/team/peer_tracker.h"
#include "vir/team/team_mapper.h"
#include "vir/team/transform_tracker.h"
#include "vir_test_heap.h"
#include "vir_test_noise.h"

namespace vir::team {
namespace {

constexpr TimeNs kBegin = 1'700'000'000'000'000'000, kStep = 100'000'000;

class Solver final : public PairSolver {
 public:
  Solver() : tracker_(options()) {}
  void add(const MutualRange& r, int a, int b) override { tracker_.add(r, a, b); }
  void setAnchors(const std::vector<SharedAnchor>& a) override { tracker_.setAnchors(a); }
  void moveA(const WorldTransform& T_new_A) override { tracker_.moveA(T_new_A); }
  TransformAnswer answer() override { return tracker_.answer(); }

 private:
  static TransformTrackerOptions options() {
    TransformTrackerOptions o;
    o.max_ranges = 200;
    return o;
  }
  TransformTracker tracker_;
};

struct Air {
  double lost = 0.3, longest_delay_s = 0.5, twice = 0.1;
};

class Member {
 public:
  Member(std::uint32_t id, std::uint32_t robots)
      : id_(id), robots_(robots), inbox_(id, {}), noise_(1000 + id) {
    begin(1);
  }

  /// Starts its program anew: another world, nothing known.
  void begin(std::uint64_t session) {
    session_ = session;
    T_G_own_ = {2 * M_PI * noise_.uniform(), Vec3(3 * noise_.normal(), 3 * noise_.normal(), 0.5)};
    inbox_ = PeerInbox(id_, {});
    tracker_ = std::make_unique<PeerTracker>(
        PeerTrackerOptions{2.0, true, 2.0, 20},
        [](const LogSink&) { return std::make_unique<Solver>(); }, LogSink());
    mapper_ = TeamMapper();
    worlds_.clear();
    sequence_ = 0;
  }

  Vec3 truth(double s) const {
    const double place = 2 * M_PI * id_ / robots_, k = id_;
    return Vec3(6 * std::cos(place) + 2.5 * std::sin(0.35 * s + k),
                6 * std::sin(place) + 2.5 * std::sin(0.26 * s + 2 * k),
                1 + 0.8 * std::sin(0.19 * s + 3 * k));
  }
  Vec3 trueIn(const Member& other, double s) const { return other.T_G_own_.inverse() * truth(s); }
  /// Where it takes itself to be: an error that wanders.
  Vec3 estimate(double s) const {
    const Vec3 error(std::sin(0.05 * s + id_), std::cos(0.04 * s), 0.5 * std::sin(0.07 * s));
    return T_G_own_.inverse() * truth(s) + 0.03 * error;
  }

  PeerReport report(TimeNs t, double s, const std::vector<Member*>& neighbours, bool second) {
    PeerReport r;
    r.robot = id_;
    r.session = session_;
    r.sequence = sequence_++;
    r.t = t;
    r.T_W_B.p = estimate(s);
    r.covariance.diagonal() << 0.0016, 0.0016, 0.0009, 1e-4, 1e-4, 1e-4;
    StateEstimate e;
    e.valid = true;
    e.state.t = t;
    e.state.T_W_B = r.T_W_B;
    e.covariance = r.covariance;
    tracker_->advance(t);
    tracker_->addState(e);
    for (Member* other : neighbours) {
      Range range;
      range.t = t;
      range.anchor = other->id_;
      range.range_m = (truth(s) - other->truth(s)).norm() + 0.05 * noise_.normal();
      range.sigma_m = 0.05;
      tracker_->addRange(range);
      r.ranges.push_back(range);
    }
    tracker_->use([] { return std::vector<Anchor>(); });
    if (second) {
      std::vector<ToldTransform> transforms;
      for (const PeerResult& p : tracker_->peers()) {
        const auto w = worlds_.find(static_cast<std::uint32_t>(p.id));
        if (p.transform.answer.status != TransformStatus::unique || !p.told || w == worlds_.end() ||
            w->second.pose.world != p.told->segment) {
          continue;
        }
        const TransformSolution& best = p.transform.answer.solutions[0];
        transforms.push_back({w->second.id, best.T_A_B, best.covariance});
      }
      mapper_.setOwn({id_, session_, 0}, t, transforms);
      mapper_.solve(t);
      r.team = mapper_.told();
    }
    return r;
  }

  void hear(const PeerReport& r, TimeNs now) {
    const auto heard = inbox_.add(r, now, toSeconds(now - kBegin));
    if (!heard) return;
    tracker_->advance(now);
    tracker_->hear(heard->pose);
    for (const Range& range : heard->ranges) tracker_->addRange(range);
    if (heard->team) mapper_.hear(heard->world, r.t, *heard->team);
    HeardWorld& w = worlds_[r.robot];
    if (!(w.id == heard->world) || heard->pose.t > w.pose.t) w = {heard->world, heard->pose};
  }

  /// Error of where it places another one [m], as that last told; none: it does not.
  std::optional<double> errorOf(const Member& other) const {
    const auto place = mapper_.places().find(other.id_), own = mapper_.places().find(id_);
    const auto w = worlds_.find(other.id_);
    if (place == mapper_.places().end() || own == mapper_.places().end() || w == worlds_.end() ||
        !(place->second.world == w->second.id)) {
      return std::nullopt;
    }
    const WorldTransform T_own_other = own->second.T_C_world.inverse() * place->second.T_C_world;
    const double s = toSeconds(w->second.pose.t - kBegin);
    return (T_own_other * w->second.pose.T_W_B.p - other.trueIn(*this, s)).norm();
  }
  const TeamMapper& mapper() const { return mapper_; }
  /// The common frame on the ground.
  WorldTransform frame() const { return T_G_own_ * mapper_.frame()->T_C_own.inverse(); }

 private:
  struct HeardWorld {
    WorldId id;
    PeerPose pose;
  };
  std::uint32_t id_, robots_, sequence_ = 0;
  std::uint64_t session_ = 1;
  WorldTransform T_G_own_;
  PeerInbox inbox_;
  std::unique_ptr<PeerTracker> tracker_;
  TeamMapper mapper_;
  std::map<std::uint32_t, HeardWorld> worlds_;
  test::Noise noise_;
};

/// Each ranges to the next two on a circle, twice per second, and tells ten poses per second.
class TeamAtWork {
 public:
  explicit TeamAtWork(std::uint32_t robots, const Air& air = {}) : air_(air) {
    for (std::uint32_t i = 0; i < robots; ++i) {
      members_.push_back(std::make_unique<Member>(i, robots));
    }
  }
  void runTo(double until_s) {
    const double cpu = threadCpuSeconds();
    for (; s() < until_s; ++step_) {
      const TimeNs now = kBegin + step_ * kStep;
      deliver(now);
      const std::size_t n = members_.size();
      for (std::size_t i = 0; i < n; ++i) {
        std::vector<Member*> neighbours;
        if ((step_ + static_cast<long>(i)) % 5 == 0) {
          for (std::size_t k = 1; k <= 2 && k < n; ++k) {
            neighbours.push_back(members_[(i + k) % n].get());
          }
        }
        send(i, now, members_[i]->report(now, s(), neighbours, step_ % 10 == 0));
      }
    }
    cpu_s_ += threadCpuSeconds() - cpu;
  }
  double s() const { return 0.1 * static_cast<double>(step_); }
  double cpuPerRobotAndSecond() const {
    return cpu_s_ / s() / static_cast<double>(members_.size());
  }
  Member& at(std::size_t i) { return *members_[i]; }
  std::size_t size() const { return members_.size(); }

 private:
  void send(std::size_t from, TimeNs now, const PeerReport& r) {
    for (std::size_t to = 0; to < members_.size(); ++to) {
      if (to == from || noise_.uniform() < air_.lost) continue;
      for (int k = noise_.uniform() < air_.twice ? 2 : 1; k > 0; --k) {
        on_the_way_.emplace(now + fromSeconds(air_.longest_delay_s * noise_.uniform()),
                            std::pair(to, r));
      }
    }
  }
  void deliver(TimeNs now) {
    while (!on_the_way_.empty() && on_the_way_.begin()->first <= now) {
      const auto& [to, r] = on_the_way_.begin()->second;
      members_[to]->hear(r, now);
      on_the_way_.erase(on_the_way_.begin());
    }
  }

  Air air_;
  std::vector<std::unique_ptr<Member>> members_;
  std::multimap<TimeNs, std::pair<std::size_t, PeerReport>> on_the_way_;
  test::Noise noise_{7};
  long step_ = 0;
  double cpu_s_ = 0;
};

/// What all place of all, but for themselves.
struct Placed {
  double worst_m = 0, rms_m = 0;
  int missing = 0;
};
Placed placedIn(TeamAtWork& team) {
  Placed out;
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < team.size(); ++i) {
    for (std::size_t j = 0; j < team.size(); ++j) {
      if (i == j) continue;
      const auto error = team.at(i).errorOf(team.at(j));
      if (!error) {
        ++out.missing;
        continue;
      }
      out.worst_m = std::max(out.worst_m, *error);
      sum += *error * *error;
      ++n;
    }
  }
  out.rms_m = n > 0 ? std::sqrt(sum / n) : 0;
  return out;
}

TEST(TenRobots, EverybodyIsPlacedByEverybodyAndNothingGrows) {
  TeamAtWork team(10);
  long held = 0;
  for (const double s : {60.0, 120.0, 180.0, 240.0, 300.0}) {
    team.runTo(s);
    const Placed p = placedIn(team);
    std::printf("%.0f s: worst %.3f m, rms %.3f m, not placed %d of 90\n", s, p.worst_m, p.rms_m,
                p.missing);
    EXPECT_EQ(p.missing, 0) << s;
    EXPECT_LT(p.worst_m, 0.15) << s;
    if (s == 180) held = test::HeapPeak::now();
  }
  if (test::heapIsCounted()) {
    const double grown = 1e-3 * static_cast<double>(test::HeapPeak::now() - held);
    std::printf("grown by %.0f kB in two minutes\n", grown);
    EXPECT_LT(grown, 200);
  }
  for (std::size_t i = 0; i < 10; ++i) EXPECT_TRUE(team.at(i).mapper().leftOut().empty()) << i;
}

TEST(TenRobots, TheCommonFrameStaysWhenItsFounderStartsAgain) {
  TeamAtWork team(5);
  team.runTo(60);
  const WorldTransform before = team.at(3).frame();
  team.at(0).begin(2);
  team.runTo(125);
  const Placed p = placedIn(team);
  EXPECT_EQ(p.missing, 0);
  EXPECT_LT(p.worst_m, 0.2);
  for (std::size_t i = 0; i < 5; ++i) {
    const WorldTransform now = team.at(i).frame();
    EXPECT_EQ(team.at(i).mapper().frame()->founder.session, 1u) << i;
    EXPECT_LT((now.t_m - before.t_m).norm(), 0.25) << i;
    EXPECT_LT(std::abs(wrapAngle(now.yaw_rad - before.yaw_rad)), 0.04) << i;
  }
}

TEST(TenRobots, WhatARobotHasToComputeGrowsNoFasterThanTheTeam) {
  double cpu[3];
  int i = 0;
  for (const std::uint32_t robots : {2u, 5u, 10u}) {
    TeamAtWork team(robots);
    team.runTo(60);
    cpu[i++] = 1e3 * team.cpuPerRobotAndSecond();
    std::printf("%u robots: %.2f ms per robot and second\n", robots, cpu[i - 1]);
  }
  // Two neighbours more than with two robots; reports of nine instead of one.
  EXPECT_LT(cpu[2], 9 * cpu[0]);
  EXPECT_LT(cpu[2], 2.5 * cpu[1]);
}

}  // namespace
}  // namespace vir::team
