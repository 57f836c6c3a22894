/// Loops among aisles of identical shelves: how many are found, how many are wrong.
/// places_lookalike UNIQUE_PER_BAY DRIFT [ROUNDS [SEED [AGREEING [RANGE_SIGMA_M [SCALE]]]]]; DRIFT
/// as a share of a metre's way per root of the way, 0: nothing is known of the path.
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "lookalike_place.h"
#include "vir/places/loop_finder.h"

using namespace vir;

int main(int argc, char** argv) {
  vir_test::AisleOptions o;
  o.unique_per_bay = argc > 1 ? std::atoi(argv[1]) : 0;
  const double drift = argc > 2 ? std::atof(argv[2]) : 0.01;
  const int times = argc > 3 ? std::atoi(argv[3]) : 2;
  o.seed = argc > 4 ? std::atoi(argv[4]) : 1;
  places::LoopFinderOptions fo;
  if (argc > 5) fo.agreeing = std::atoi(argv[5]);
  const double range_sigma = argc > 6 ? std::atof(argv[6]) : 0;
  const double scale = argc > 7 ? std::atof(argv[7]) : 0.5;
  const auto scene = vir_test::aisles(o);
  const std::vector<Pose> truth = vir_test::rounds(o, times, 0.4);
  const vir_test::Drifting path(truth, drift > 0 ? drift : 0.01, o.seed);
  rendering::CameraSimulationOptions co;
  co.seed = o.seed;
  const CameraCalibration cc = vir_test::eurocCamera(scale);
  vir_test::PlaceMaker maker(scene, cc, co, o.seed);
  places::VerifyOptions vo;
  vo.focal_px = cc.fx;
  places::LoopFinder finder(fo, {}, vo);
  const auto prior = [&](const PlaceKeyframe& a, const PlaceKeyframe& b) {
    places::RelativePrior p = path.between(a.id, b.id);
    if (range_sigma > 0 && p.covariance(0, 0) > range_sigma * range_sigma) {
      // Ranges to anchors hold both ends of the path.
      Random random(a.id, b.id);
      const Vec3 noise(random.normal(), random.normal(), random.normal());
      p.T_older_newer.p = (truth[a.id].inverse() * truth[b.id]).p + range_sigma * noise;
      p.covariance.diagonal().head<3>().setConstant(range_sigma * range_sigma);
    }
    return std::optional<places::RelativePrior>(p);
  };
  const auto wrong = [&](const Loop& l) {
    const Pose t = truth[l.older].inverse() * truth[l.newer];
    return (l.T_older_newer.p - t.p).norm() > 0.3 || l.T_older_newer.q.angularDistance(t.q) > 0.1;
  };
  std::map<std::string, int> decisions, wrong_decisions;
  int pairs = 0, appear_right = 0, appear_any = 0, possible = 0, verified = 0, verified_wrong = 0,
      loops = 0, false_loops = 0;
  std::set<std::uint64_t> closed;
  std::vector<double> nees;
  std::vector<int> inliers_right, inliers_wrong;
  std::vector<int> share_right, share_wrong;
  double points = 0;
  const std::size_t per_round = truth.size() / static_cast<std::size_t>(times);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const TimeNs t = fromSeconds(0.5 * static_cast<double>(k));
    const auto& image = maker.take(truth[k], std::fmod(toSeconds(t), 1000));
    auto kf = maker.describe(image, k, t, truth[k]);
    const auto compare = [&](const std::vector<places::ExpectedPoint>& expected) {
      return maker.compare(image, truth[k], expected);
    };
    kf->T_W_B = path.poses[k];
    points += kf->points.size();
    const auto found =
        finder.add(kf, drift > 0 ? places::LoopFinder::Prior(prior) : places::LoopFinder::Prior(),
                   {}, compare);
    possible += k >= per_round;
    bool right = false, any = false;
    for (const auto& a : finder.attempts()) {
      ++pairs;
      ++decisions[a.decision];
      const Pose rel = truth[a.older].inverse() * truth[a.newer];
      right |= rel.p.norm() < 1 && rel.q.angularDistance(Quat::Identity()) < 0.4;
      any = true;
      if (!a.verdict.found) continue;
      ++verified;
      const bool bad = wrong(*a.verdict.found);
      verified_wrong += bad;
      (bad ? inliers_wrong : inliers_right).push_back(a.verdict.inliers);
      (bad ? share_wrong : share_right).push_back(static_cast<int>(100 * a.verdict.share));
      if (bad) ++wrong_decisions[a.decision];
      if (!bad)
        nees.push_back(
            places::loopChi2(*a.verdict.found, {rel, Eigen::Matrix<double, 6, 6>::Zero()}));
    }
    appear_right += k >= per_round && right;
    appear_any += any;
    for (const Loop& l : found) {
      ++loops;
      if (wrong(l)) {
        ++false_loops;
        const Pose t = truth[l.older].inverse() * truth[l.newer];
        std::printf("  wrong: %d-%d off %.2f m %.2f rad, inliers %d\n", (int)l.older, (int)l.newer,
                    (l.T_older_newer.p - t.p).norm(), l.T_older_newer.q.angularDistance(t.q),
                    l.inliers);
      } else if (l.newer >= per_round) {
        closed.insert(l.newer);
      }
    }
  }
  std::printf("%.0f points per keyframe\n", points / static_cast<double>(truth.size()));
  const auto quantiles = [](const char* what, std::vector<int>* all) {
    std::sort(all->begin(), all->end());
    if (all->empty()) return;
    std::printf("%s: 5 %% %d, median %d, 95 %% %d\n", what, (*all)[all->size() / 20],
                (*all)[all->size() / 2], (*all)[all->size() * 19 / 20]);
  };
  quantiles("corners of right ones", &inliers_right);
  quantiles("corners of wrong ones", &inliers_wrong);
  quantiles("share of right ones [%]", &share_right);
  quantiles("share of wrong ones [%]", &share_wrong);
  std::sort(nees.begin(), nees.end());
  std::printf("%zu keyframes, %d second visits, %d pairs, right place among candidates %d\n",
              truth.size(), possible, pairs, appear_right);
  std::printf("verified %d (%d wrong), loops %d (%d wrong), second visits closed %zu = %.0f %%\n",
              verified, verified_wrong, loops, false_loops, closed.size(),
              100.0 * closed.size() / std::max(1, possible));
  for (const auto& [d, n] : decisions)
    std::printf("  %-28s %d (wrong verified %d)\n", d.c_str(), n, wrong_decisions[d]);
  if (!nees.empty()) {
    double sum = 0;
    for (double v : nees) sum += v;
    std::printf("NEES/6 mean %.2f median %.2f 95%% %.2f\n", sum / nees.size() / 6,
                nees[nees.size() / 2] / 6, nees[nees.size() * 95 / 100] / 6);
  }
  std::printf("path drift at the end %.2f m, index %.1f MB\n",
              (path.poses.back().p - truth.back().p).norm(), finder.index().bytes() / 1e6);
  return 0;
}
