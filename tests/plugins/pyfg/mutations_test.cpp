/// Files broken at random (but the same way every time): whatever they hold, the reader either
/// gives events in time order with finite numbers or throws InputError or SettingsError.
#include <gtest/gtest.h>

#include <random>

#include "input_error.h"
#include "robot_recording.h"
#include "vir/core/settings.h"
#include "vir_test_pyfg.h"
#include "vir_test_temp_folder.h"

namespace vir::pyfg {
namespace {

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::string operator()(std::string text) {
    const int changes = 1 + static_cast<int>(below(12));
    for (int i = 0; i < changes && !text.empty(); ++i) change(&text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }

  void change(std::string* s) {
    static const char* const words[] = {"nan",  "inf", "-1",        "1e400", "0", "A0", "B1",
                                        "L0",   "\r",  "EDGE_SE2 ", "\n",    "#", ",",  "1e-400",
                                        "-0.0", " ",   "1e18",      "A3 A1", "+", "."};
    const std::size_t at = below(s->size());
    switch (below(6)) {
      case 0:  // any byte
        (*s)[at] = static_cast<char>(below(256));
        break;
      case 1:
        s->insert(at, words[below(std::size(words))]);
        break;
      case 2:
        s->erase(at, 1 + below(40));
        break;
      case 3:  // a piece once more somewhere else
        s->insert(below(s->size()), s->substr(at, below(200)));
        break;
      case 4:  // cut off
        if (below(8) == 0) s->resize(at);
        break;
      default: {  // a word replaced
        const std::size_t from = s->find_first_of(" \n", at);
        if (from == s->npos) break;
        const std::size_t to = std::min(s->find_first_of(" \n", from + 1), s->size());
        s->replace(from + 1, to - from - 1, words[below(std::size(words))]);
      }
    }
  }

  std::mt19937_64 random_;
};

bool finite(const Event& e) {
  if (const auto* p = std::get_if<TruePose>(&e.what)) return p->T_W_B.p.allFinite();
  if (const auto* r = std::get_if<AnchorRange>(&e.what))
    return std::isfinite(r->range_m / r->sigma_m);
  if (const auto* r = std::get_if<PeerRange>(&e.what))
    return std::isfinite(r->range_m / r->sigma_m);
  const auto& o = std::get<OdometryPose>(e.what);
  return o.T_O_B.p.allFinite() && o.T_O_B.q.coeffs().allFinite() &&
         std::abs(o.T_O_B.q.norm() - 1) < 1e-9 && o.step_covariance.allFinite() && o.t == e.t;
}

TEST(PyfgMutations, NeverCrashNeverNonsense) {
  const test::TempFolder folder;
  const std::string file = (folder / "m.pyfg").string();
  std::string spatial;
  for (int i = 0; i < 6; ++i) {
    const std::string a = "A" + std::to_string(i), b = "A" + std::to_string(i + 1);
    spatial += "VERTEX_SE3:QUAT 5" + std::to_string(i) + " " + a + " 1 2 3 0 0 0.6 0.8\n";
    spatial += "EDGE_SE3:QUAT 5" + std::to_string(i + 1) + " " + a + " " + b + " 1 0 0 0 0 0 1 " +
               test::kSpatialCovariance + "\n";
  }
  const std::string good = test::twoRobots(6) + spatial;
  int read = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    test::writeText(file, Mutator(seed)(seed % 3 == 0 ? good : test::twoRobots(3)));
    try {
      ProblemLog log;
      PyfgOptions options;
      options.robot = "A";
      const RobotRecording r = extractRobot(readGraph(file, &log), options, &log);
      TimeNs last = 0;
      for (const Event& e : r.events) {
        ASSERT_TRUE(finite(e)) << "seed " << seed;
        ASSERT_LE(last, e.t) << "seed " << seed;
        last = e.t;
      }
      ++read;
    } catch (const InputError&) {
      ++refused;
    } catch (const SettingsError&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 2500);
  EXPECT_GT(refused, 0) << "nothing broken enough";
}

}  // namespace
}  // namespace vir::pyfg
