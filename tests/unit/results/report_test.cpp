/// The pictures and the page of a run, from a made-up run. VIR_KEEP_REPORT=FOLDER keeps it, to be
/// looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "frame_history.h"
#include "silent_estimator.h"
#include "vir/results/run_recorder.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr TimeNs kStart = 1'700'000'000'000'000'000;

/// Gives at the end what the test says.
class Told : public SilentEstimator {
 public:
  std::vector<Anchor> anchors() const override { return anchors_; }
  std::optional<std::vector<LoopRecord>> loops() const override { return loops_; }

  std::vector<Anchor> anchors_;
  std::optional<std::vector<LoopRecord>> loops_;
};

Vec3 path(double t) {
  return {4 * std::sin(0.12 * t), 3 * std::sin(0.24 * t), 1 + 0.3 * std::sin(0.4 * t)};
}

class Report : public testing::Test {
 protected:
  void SetUp() override {
    const char* keep = std::getenv("VIR_KEEP_REPORT");
    results_ = std::make_unique<ResultsFolder>(
        (keep != nullptr ? std::filesystem::path(keep) : temp_.path()) /
        testing::UnitTest::GetInstance()->current_test_info()->name());
    recorder_ = std::make_unique<RunRecorder>(*results_, LogSink());
    summary_.estimator = "told";
    summary_.rawlog = "a <b> & c.rawlog";
  }

  /// 60 s at 20 Hz; the truth is turned and shifted, the estimate drifts.
  void flight(bool truth) {
    for (int i = 0; i < 1200; ++i) {
      const double s = 0.05 * i;
      const TimeNs t = kStart + fromSeconds(s);
      StateEstimate e;
      e.state.t = t;
      e.valid = i > 20;
      e.state.T_W_B.p = path(s) + 0.004 * s * Vec3(1, -0.5, 0.1);
      e.covariance.diagonal().head<3>().setConstant(1e-4 * (1 + 0.2 * s));
      e.ms.total = 8 + 4 * std::sin(s) + (i % 100 == 0 ? 30 : 0);
      recorder_->onOutput({{e}, {}, {}, {}}, estimator_);
      const Pose T_R_W(expQuat(Vec3(0, 0, 1)), Vec3(5, 6, 7));
      const double off = i == far_truth_ ? 1e6 : 0;
      const Vec3 p = path(s) + Vec3(off, 0, 0);
      if (truth) recorder_->addGroundTruth(t, T_R_W * Pose(Quat::Identity(), p));
      if (e.valid && i % 10 == 0) {
        estimator_.keyframes_.push_back({t, {Quat::Identity(), path(s) + Vec3(0.02, 0, 0)}});
      }
    }
  }

  Anchor& anchor(std::uint64_t id, AnchorState state, const Vec3& p, const Vec3& sigma) {
    Anchor a;
    a.id = id;
    a.state = state;
    a.has_position = a.state != AnchorState::collecting;
    a.p_W = p;
    a.mirror_p_W = Vec3(p.x(), p.y(), -p.z());
    a.covariance = Vec3(sigma.cwiseProduct(sigma)).asDiagonal();
    estimator_.anchors_.push_back(a);
    return estimator_.anchors_.back();
  }

  void ranges(std::uint64_t id, const Vec3& p, double longer_share) {
    std::mt19937_64 random(id);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    for (int i = 0; i < 600; ++i) {
      const double s = 0.1 * i + 0.013;
      RangeRecord r;
      r.t = kStart + fromSeconds(s);
      r.anchor = id;
      r.predicted_m = i < 60 ? 0 : (p - path(s)).norm();
      r.sigma_m = i < 60 ? 0 : 0.05 + 0.1 * std::exp(-0.1 * s);
      const bool longer = uniform() < longer_share;
      r.residual_m = 0.05 * (uniform() + uniform() + uniform() + uniform() - 2) * 1.7;
      if (longer) r.residual_m += 0.3 + 1.5 * uniform();
      if (i < 60) r.residual_m = 0;
      r.measured_m = r.predicted_m + r.residual_m;
      r.weight = longer ? 0.1 : 1;
      r.decision = i < 60   ? RangeDecision::collected
                   : longer ? RangeDecision::too_long
                            : RangeDecision::accepted;
      if (i % 150 == 149) r.decision = RangeDecision::out_of_order;
      recorder_->onOutput({{}, {r}, {}, {}}, estimator_);
    }
  }

  /// Writes all and returns the page.
  std::string page() {
    recorder_->setFirstFrame(kStart);
    recorder_->onEnd(estimator_, &summary_);
    return read("report.html");
  }
  std::string read(const std::string& name) { return test::readText(results_->file(name)); }
  bool exists(const std::string& name) { return std::filesystem::exists(results_->file(name)); }
  /// The JSON inside the page.
  static nlohmann::json numbers(const std::string& html) {
    const std::string mark = "<script type=\"application/json\" id=\"data\">";
    const std::size_t from = html.find(mark) + mark.size();
    return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
  }
  static long count(const std::string& text, const std::string& part) {
    long n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
    return n;
  }
  /// Every number of an attribute lies on the sheet.
  static void expectOnSheet(const std::string& svg) {
    for (const std::string mark : {"points=\"", "cx=\"", "cy=\""}) {
      for (std::size_t at = svg.find(mark); at != svg.npos; at = svg.find(mark, at + 1)) {
        std::string numbers =
            svg.substr(at + mark.size(), svg.find('"', at + mark.size()) - at - mark.size());
        std::replace(numbers.begin(), numbers.end(), ',', ' ');
        std::istringstream in(numbers);
        for (double v = 0; in >> v;) {
          ASSERT_GE(v, -1) << mark << numbers.substr(0, 80);
          ASSERT_LE(v, 1400) << mark << numbers.substr(0, 80);
        }
      }
    }
    for (const char* word : {"nan", "inf"}) EXPECT_EQ(count(svg, word), 0) << word;
  }

  test::TempFolder temp_;
  int far_truth_ = -1;  // this pose of the truth is a thousand kilometres off
  std::unique_ptr<ResultsFolder> results_;
  std::unique_ptr<RunRecorder> recorder_;
  Told estimator_;
  RunSummary summary_;
};

TEST_F(Report, AFullRun) {
  flight(true);
  const Vec3 first(3, -4, 2), second(-6, 1, 3);
  anchor(0, AnchorState::estimated, first, {0.1, 0.15, 0.5}).ranges_used = 512;
  anchor(3, AnchorState::mirror_open, second, {0.4, 0.2, 1.2}).advice = "change height";
  anchor(7, AnchorState::collecting, Vec3::Zero(), Vec3::Zero()).advice = "move sideways";
  ranges(0, first, 0.05);
  ranges(3, second, 0.1);
  recorder_->setTrueAnchors(
      {{0, Vec3(5, 6, 7) + expSO3(Vec3(0, 0, 1)) * (first + Vec3(0.2, 0, 0))}});
  summary_.warnings = {"something <odd> happened"};
  const std::string html = page();
  for (const char* part :
       {"a &lt;b&gt; &amp; c.rawlog", "From above", "From the side", "Range residuals", "Anchor 3",
        "Position error", "CPU time per frame", "something &lt;odd&gt; happened", "mirror_open",
        "or at -6.000, 1.000, -3.000; change height", "ranges_accepted", "3?", "move sideways"}) {
    EXPECT_GT(count(html, part), 0) << part;
  }
  EXPECT_EQ(count(html, "ranges_accepted"), 1) << "counters of ranges stand in one place";
  EXPECT_EQ(count(html, "<svg "), 4);
  EXPECT_EQ(count(html, "</svg>"), 4);
  EXPECT_EQ(count(html, "<script"), 2) << "the numbers, and what draws them";
  for (const char* part :
       {"http-equiv", "<link", "<img", "src=", "url(", "import ", "fetch(", "<!--"}) {
    EXPECT_EQ(count(html, part), 0) << part;
  }
  expectOnSheet(html);
  expectOnSheet(read("map.svg"));
  expectOnSheet(read("ranges.svg"));
  EXPECT_EQ(read("map.svg").substr(0, 5), "<?xml");
  EXPECT_GT(count(read("ranges.svg"), "<circle"), 900);
}

TEST(FrameHistory, AReasonThatOnlyCountsOnIsOneEvent) {
  FrameHistory history;
  StateEstimate e;
  e.valid = true;
  e.health = Health::doubtful;
  for (int i = 0; i < 20; ++i) {
    e.state.t = kStart + i;
    e.reason = "no landmarks for " + std::to_string(0.1 * (15 + i)) + " s, IMU only";
    history.add(e);
  }
  e.reason = "few landmarks";
  history.add(e);
  ASSERT_EQ(history.events().size(), 2u);
  EXPECT_EQ(history.events()[0].text.substr(0, 31), "doubtful: no landmarks for 1.50");
}

TEST_F(Report, HoldsTheNumbersThatItsScriptDraws) {
  flight(true);
  anchor(0, AnchorState::estimated, {3, -4, 2}, {0.1, 0.15, 0.5});
  anchor(7, AnchorState::collecting, Vec3::Zero(), Vec3::Zero());
  ranges(0, {3, -4, 2}, 0.05);
  StateEstimate last;
  last.state.t = kStart + fromSeconds(60.0);
  last.health = Health::lost;
  last.reason = "no </script> in sight";
  recorder_->onOutput({{last}, {}, {}, {}}, estimator_);
  summary_.command = "vir-slam run \"a <b> & c.rawlog\"";
  const std::string html = page();
  EXPECT_GT(count(html, "run &quot;a &lt;b&gt; &amp; c.rawlog"), 0);
  EXPECT_GT(count(html, "first frame at 2023-11-14 22:13:20 UTC"), 0);
  const auto data = numbers(html);
  for (const char* key :
       {"t",   "x",  "y",   "z",  "yaw", "pitch", "roll", "heading", "vx",        "bgx",
        "baz", "sx", "srz", "ex", "ey",  "ez",    "erx",  "tracks",  "landmarks", "ms"}) {
    EXPECT_EQ(data["frames"][key].size(), 1201u) << key;
  }
  EXPECT_TRUE(data["frames"]["x"][20].is_null()) << "no pose yet";
  EXPECT_NEAR(data["frames"]["t"][21].get<double>(), 1.05, 1e-9);
  EXPECT_EQ(data["truth"]["t"].size(), 1179u);
  EXPECT_NEAR(data["anchors"][0]["root"][2][2].get<double>(), 0.5, 1e-6);
  EXPECT_TRUE(data["anchors"][1]["p"].is_null());
  EXPECT_EQ(data["ranges"]["t"].size(), 600u);
  EXPECT_EQ(data["decisions"][0], "accepted");
  EXPECT_EQ(data["events"].back()[1], "lost: no </script> in sight");
  EXPECT_EQ(data["events"].back()[2], true);
}

/// The band is of the world that began where the estimate did: the error there is none, and grows
/// by what the estimate drifts (4 mm, -2 mm and 0.4 mm per second) in the axes of that world.
TEST_F(Report, ErrorsAreInTheFrameOfTheirBand) {
  flight(true);
  for (StampedPose& k : estimator_.keyframes_) k.T_W_B.p -= Vec3(0.02, 0, 0);  // at the truth
  const auto data = numbers(page());
  const auto at = [&](const char* key) { return data["frames"][key][1199].get<double>(); };
  const double s = 59.95;
  EXPECT_NEAR(at("ex"), 0.004 * s, 2e-4);
  EXPECT_NEAR(at("ey"), -0.002 * s, 2e-4);
  EXPECT_NEAR(at("ez"), 0.0004 * s, 2e-4);
  EXPECT_NEAR(at("erz"), 0, 1e-3);
}

TEST_F(Report, WithoutTruthAndRanges) {
  flight(false);
  const std::string html = page();
  EXPECT_FALSE(numbers(html)["frames"].contains("ex"));
  EXPECT_EQ(count(html, "<svg "), 2) << "map and CPU";
  EXPECT_EQ(count(html, "ground truth"), 0);
  EXPECT_TRUE(exists("map.svg"));
  EXPECT_FALSE(exists("ranges.svg"));
}

TEST_F(Report, SecondVisitsAreOnTheMap) {
  flight(false);
  LoopRecord l;
  l.p_older = path(2);
  l.p_newer = path(54);
  l.accepted = true;
  estimator_.loops_.emplace({l});
  l.accepted = false;
  l.p_newer = path(31);
  estimator_.loops_->insert(estimator_.loops_->end(), 20000, l);
  const auto data = numbers(page());
  EXPECT_NEAR(data["loops"]["y"][1].get<double>(), path(2).y(), 1e-3);
  EXPECT_LT(data["loops_refused"]["x"].size(), 10000u);
  const std::string map = read("map.svg");
  EXPECT_GT(count(map, "places seen twice"), 0);
  EXPECT_GT(count(map, ">refused"), 0);
  EXPECT_LT(map.size(), 200000u);  // not all of them
}

TEST_F(Report, NoPoseAtAll) {
  summary_.longest_wait_reason = "too little parallax";
  summary_.error = "told to stop";
  const std::string html = page();
  EXPECT_EQ(count(html, "<svg "), 0);
  EXPECT_GT(count(html, "No pose at all. too little parallax"), 0);
  EXPECT_GT(count(html, "told to stop"), 0);
  EXPECT_FALSE(exists("map.svg"));
}

TEST_F(Report, CalibrationOverTimeWhereItWasEstimated) {
  const auto calibrating = [&](bool online) {
    recorder_ = std::make_unique<RunRecorder>(*results_, LogSink());
    estimator_ = {};
    summary_ = {};
    Calibration given;
    given.camera = {752, 480, 460, 460, 376, 240};
    summary_.calibration_given = given;
    for (int i = 0; i < 1200; ++i) {
      StateEstimate e;
      e.state.t = kStart + fromSeconds(0.05 * i);
      e.valid = i > 20;
      e.state.T_W_B.p = path(0.05 * i);
      roles::EstimatorOutput output{{e}, {}, {}, {}};
      if (e.valid && online) {
        const double left = std::exp(-0.01 * i);
        Calibration now = changed(given, CalibrationChange::Constant(0.005 * (1 - left)));
        if (i == 500) now.time_offset_s = kNan;
        CalibrationSigma sigma;
        sigma.focal *= left;
        output.calibrations.push_back({e.state.t, now, sigma});
      }
      recorder_->onOutput(output, estimator_);
    }
    return page();
  };
  const std::string html = calibrating(true);
  for (const char* part : {"Calibration over time", "time offset [ms]", "fx [px]", "rotation [deg]",
                           "position [mm]", "less what was given"}) {
    EXPECT_GT(count(html, part), 0) << part;
  }
  EXPECT_EQ(count(html, "<polygon "), 8) << "a band for each of eight numbers";
  EXPECT_EQ(count(html, "<svg "), 2) << "map and calibration";
  expectOnSheet(html);
  const std::string trusted = calibrating(false);
  EXPECT_EQ(count(trusted, "Calibration over time"), 0);
  EXPECT_EQ(count(trusted, "<svg "), 1);
}

TEST_F(Report, AbsurdAnchorsAndRangesStayOnTheSheet) {
  flight(true);
  anchor(0, AnchorState::estimated, {1, 1, 1}, {1e6, 0.01, 1e9});
  anchor(1, AnchorState::estimated, {1e7, 0, 0}, {1, 1, 1});
  anchor(2, AnchorState::estimated, {kNan, 0, 0}, {1, 1, 1});
  anchor(3, AnchorState::mirror_open, {0, 0, 2}, {kNan, 1, 1}).mirror_p_W = Vec3(1e9, kNan, 0);
  anchor(4, AnchorState::estimated, {0, 0, 3}, {0, 0, 0}).covariance = -Mat3::Identity();
  ranges(0, {1, 1, 1}, 0);
  for (const double v : {1e9, -1e9, kNan, std::numeric_limits<double>::infinity()}) {
    recorder_->onOutput({{}, {{kStart, 0, v, 3, v, 0.1, 1, RangeDecision::accepted}}, {}, {}},
                        estimator_);
    recorder_->onOutput({{}, {{kStart, 9, 3, 3, 0, v, 1, RangeDecision::invalid}}, {}, {}},
                        estimator_);
  }
  const std::string html = page();
  expectOnSheet(html);
  EXPECT_EQ(count(html, "<b>&"), 0);
  EXPECT_GT(count(html, "too far away: anchor 1"), 0);
  for (const char* name : {"anchors.csv", "ranges.csv"}) {
    EXPECT_EQ(count(read(name), "nan") + count(read(name), "inf"), 0) << name;
  }
}

/// It made an error of kilometres, and a map of them.
TEST_F(Report, TruthThatCannotBeIsLeftOutAndSaid) {
  far_truth_ = 700;
  flight(true);
  const std::string html = page();
  ASSERT_TRUE(summary_.ate_posyaw_m);
  EXPECT_LT(*summary_.ate_posyaw_m, 0.2);
  const std::pair<std::string, long> counted{"ground_truth_left_out", 1};
  EXPECT_EQ(std::count(summary_.counters.begin(), summary_.counters.end(), counted), 1);
  EXPECT_GT(count(html, "1 pose of the reference left out"), 0);
  expectOnSheet(read("map.svg"));
}

TEST_F(Report, ALongRunHasSmallPictures) {
  for (int i = 0; i < 72000; ++i) {  // an hour
    StateEstimate e;
    e.state.t = kStart + fromSeconds(0.05 * i);
    e.valid = true;
    e.state.T_W_B.p = path(0.05 * i);
    e.ms.total = 10 + (i * 7919) % 13;
    recorder_->onOutput({{e}, {}, {}, {}}, estimator_);
    recorder_->addGroundTruth(e.state.t,
                              {Quat::Identity(), path(0.05 * i) + Vec3(0.001 * (i % 11), 0, 0)});
    const RangeRecord r{e.state.t, 0, 3, 3, 0.01, 0.1, 1, RangeDecision::accepted};
    recorder_->onOutput({{}, {r}, {}, {}}, estimator_);
  }
  page();
  const auto size = std::filesystem::file_size(results_->file("report.html"));
  EXPECT_LT(size, 3'000'000u);
  EXPECT_EQ(count(read("ranges.csv"), "\n"), 72001);
}

TEST_F(Report, TwiceTheSameBytes) {
  flight(true);
  anchor(0, AnchorState::estimated, {3, -4, 2}, {0.1, 0.15, 0.5});
  ranges(0, {3, -4, 2}, 0.05);
  const RunSummary before = summary_;
  const std::string first = page();
  recorder_ = std::make_unique<RunRecorder>(*results_, LogSink());
  estimator_ = {};
  summary_ = before;
  flight(true);
  anchor(0, AnchorState::estimated, {3, -4, 2}, {0.1, 0.15, 0.5});
  ranges(0, {3, -4, 2}, 0.05);
  EXPECT_EQ(page(), first);
}

}  // namespace
}  // namespace vir::results
