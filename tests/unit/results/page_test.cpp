/// Pages in a browser: nothing fails, controls move what they should, and a telephone shows all.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "silent_estimator.h"
#include "vir/results/meeting_page.h"
#include "vir/results/run_recorder.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;

class Still : public SilentEstimator {
 public:
  std::vector<Landmark> landmarks() const override { return {{1, {1, 2, 0.5}}, {2, {3, 1, 1}}}; }
  std::vector<Anchor> anchors() const override {
    Anchor a;
    a.id = 4;
    a.has_position = true;
    a.state = AnchorState::estimated;
    a.p_W = {3, -2, 2};
    a.covariance = 0.04 * Mat3::Identity();
    return {a};
  }
  roles::EstimatorReport report() const override { return {}; }
};

/// Told to the page before its own script runs: what goes wrong, and afterwards what moves.
const char* const kProbe = R"(<script>
const wrong = [];
// Nobody looks: pictures would be made when it suits the browser.
window.requestAnimationFrame = (f) => setTimeout(() => f(performance.now()), 1);
addEventListener('error', (e) => wrong.push(e.message));
addEventListener('unhandledrejection', (e) => wrong.push(String(e.reason)));
const consoleError = console.error;
console.error = (...a) => { wrong.push(a.join(' ')); consoleError(...a); };
addEventListener('load', async () => {
  const wait = () => new Promise((done) => setTimeout(done, 200));
  const look = () => [...document.querySelectorAll('#live canvas')].map((c) => c.toDataURL());
  const changed = (a, b) => a.filter((v, i) => v !== b[i]).length;
  const out = {};
  await wait();
  const slider = document.getElementById('time');
  const parts = [...document.querySelectorAll('body > :not(.bar), #live *')];
  out.right = Math.max(...parts.map((e) => e.getBoundingClientRect().right));
  out.canvases = look().length;
  // A browser that cannot draw in space does without two.
  out.in_space = document.querySelectorAll('#live .space').length;
  out.still_hidden = document.getElementById('still').hidden;
  out.wide = document.documentElement.scrollWidth - innerWidth;
  if (slider) {
    let before = look();
    slider.value = 1000;
    slider.dispatchEvent(new Event('input'));
    await wait();
    out.now = document.getElementById('now').textContent;
    out.moved_by_slider = changed(before, look());
    before = look();
    const chart = document.querySelector('.chart canvas'), box = chart.getBoundingClientRect();
    const at = {clientX: box.left + 52 + 0.5 * (box.width - 60), clientY: box.top + 50, bubbles: true};
    chart.dispatchEvent(new WheelEvent('wheel', {...at, deltaY: -400, cancelable: true}));
    await wait();
    out.span = page.clock.span;
    out.zoomed_charts = changed(before, look());
    chart.dispatchEvent(new PointerEvent('pointermove', at));
    await wait();
    out.hovered = page.clock.now;
    before = look();
    const map = document.querySelector('.map select');
    map.selectedIndex = 1;
    map.dispatchEvent(new Event('change'));
    await wait();
    out.turned_map = changed(before, look());
    out.legend = document.querySelector('.chart .legend').textContent;
    document.querySelector('.events button').click();
    await wait();
    out.after_event = page.clock.now;
  }
  out.wrong = wrong;
  document.body.append(Object.assign(document.createElement('pre'), {id: 'probe', textContent: JSON.stringify(out)}));
});
</script>)";

class Page : public testing::Test {
 protected:
  void SetUp() override {
    if (test::shell("command -v chromium").text.empty()) {
      GTEST_SKIP() << "there is no chromium: scripts/install_dependencies.sh --browser";
    }
    recorder_ = std::make_unique<RunRecorder>(folder_, LogSink());
    summary_.rawlog = "a.rawlog";
    summary_.frames = 400;
  }

  void flight() {
    for (int i = 0; i < 400; ++i) {
      const double s = 0.05 * i;
      StateEstimate e;
      e.state.t = kStart + fromSeconds(s);
      e.valid = i >= 10;
      e.health = i < 10 ? Health::starting : i < 300 ? Health::ok : Health::doubtful;
      e.state.T_W_B.p = Vec3(3 * std::sin(0.4 * s), 2 * std::sin(0.8 * s), 1 + 0.1 * s);
      e.state.v = Vec3(std::cos(s), std::sin(s), 0.1);
      e.covariance.diagonal().setConstant(1e-4 * (1 + s));
      e.tracks = 100 + i % 20;
      e.ms.total = 5;
      recorder_->onOutput({{e}, {}, {}, {}}, estimator_);
      recorder_->addGroundTruth(e.state.t, e.state.T_W_B);
      const RangeRecord r{e.state.t, 4, 3, 3, 0.05 * std::sin(s), 0.1, 1, RangeDecision::accepted};
      recorder_->onOutput({{}, {r}, {}, {}}, estimator_);
    }
  }

  std::string pageOfTheRun() {
    recorder_->setFirstFrame(kStart);
    recorder_->onEnd(estimator_, &summary_);
    return test::readText(folder_.file("report.html"));
  }

  /// What the probe found in a window so wide.
  nlohmann::json probe(std::string html, int width) {
    html.insert(html.find("<meta charset"), kProbe);
    test::writeText(temp_ / "probed.html", html);
    const std::string home = test::quoted((temp_ / "profile").string());
    const test::Outcome outcome =
        test::shell("HOME=" + home +
                    " timeout 280 chromium --headless --no-sandbox --disable-gpu-sandbox "
                    "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader "
                    "--disable-background-networking --disable-component-update --disable-sync "
                    "--disable-accelerated-2d-canvas --disable-extensions --no-first-run "
                    "--disable-dev-shm-usage --user-data-dir=" +
                    home + " --window-size=" + std::to_string(width) +
                    ",900 --virtual-time-budget=3000 --dump-dom 'file://" +
                    (temp_ / "probed.html").string() + "' 2>/dev/null");
    const std::string mark = "<pre id=\"probe\">";
    const std::size_t from = outcome.text.find(mark);
    if (from == std::string::npos) return {};
    const std::size_t begin = from + mark.size();
    return nlohmann::json::parse(
        outcome.text.substr(begin, outcome.text.find("</pre>", begin) - begin));
  }

  test::TempFolder temp_;
  ResultsFolder folder_{(temp_ / "run").string()};
  std::unique_ptr<RunRecorder> recorder_;
  Still estimator_;
  RunSummary summary_;
};

TEST_F(Page, ControlsMoveWhatTheyShould) {
  flight();
  const nlohmann::json found = probe(pageOfTheRun(), 1200);
  ASSERT_TRUE(found.is_object()) << "the page's script did not come to its end";
  EXPECT_EQ(found["wrong"], nlohmann::json::array());
  EXPECT_EQ(found["still_hidden"], true);
  EXPECT_LE(found["wide"].get<double>(), 0) << "to be scrolled sideways";
  EXPECT_GE(found["canvases"], 10);
  EXPECT_EQ(found["now"], "10.0 s");
  EXPECT_GE(found["moved_by_slider"], 10) << "map, space and charts";
  const double span = found["span"][1].get<double>() - found["span"][0].get<double>();
  EXPECT_LT(span, 12) << "of 20 s";
  EXPECT_GE(found["zoomed_charts"], 9) << "all charts share the time";
  EXPECT_NEAR(found["hovered"].get<double>(), 10, 0.1) << "the wheel zooms about the pointer";
  EXPECT_EQ(found["turned_map"], 1);
  EXPECT_NE(found["legend"].get<std::string>().find(" m"), std::string::npos) << found["legend"];
  EXPECT_EQ(found["after_event"], 0);
}

TEST_F(Page, FitsATelephone) {
  flight();
  // A headless window is 500 px wide at least: the page is to make do with less of it.
  std::string html = pageOfTheRun();
  html.insert(html.find("</head>"), "<style>body { max-width: 400px; margin: 0; }</style>");
  const nlohmann::json found = probe(html, 500);
  ASSERT_TRUE(found.is_object());
  EXPECT_EQ(found["wrong"], nlohmann::json::array());
  EXPECT_LE(found["right"].get<double>(), 400.5) << "nothing sticks out";
}

TEST_F(Page, RobotsThatMet) {
  team::Meeting meeting;
  for (const char* name : {"A", "B <b>"}) {
    team::RobotRecord robot;
    robot.name = name;
    robot.anchors = {{kStart, estimator_.anchors()}};
    robot.landmarks = estimator_.landmarks();
    const double shift = name[0] == 'A' ? 0 : 3;
    Trajectory path;
    for (int i = 0; i < 200; ++i) {
      const double s = 0.1 * i;
      path.push_back(
          {kStart + fromSeconds(s), {Quat::Identity(), {shift + std::sin(s), 0.2 * s, 1}}});
    }
    meeting.map.trajectories[name] = path;
    meeting.map.T_root[name] = {0, {shift, 0, 0}};
    meeting.robots.push_back(robot);
  }
  meeting.map.root = "A";
  team::PairResult pair;
  pair.transform.from = "B <b>";
  pair.transform.to = "A";
  pair.ranges.list.resize(1);
  pair.ranges.list[0].range.t = kStart + fromSeconds(2.0);
  for (int i = 0; i < 30; ++i) {
    team::TransformAnswer answer;
    answer.status = i < 10 ? team::TransformStatus::ambiguous : team::TransformStatus::unique;
    answer.reason = i < 10 ? "drive on" : "";
    answer.solutions.resize(1);
    answer.solutions[0].T_A_B = {0.1 + 0.001 * i, {3, 0.5, 0.01 * i}};
    answer.solutions[0].covariance = Eigen::Matrix4d::Identity() / (1 + i);
    pair.history.push_back({0.5 * i, answer});
    pair.transform.answer = answer;
  }
  meeting.pairs.push_back(pair);
  const std::string html = meetingHtml({meeting,
                                        {"A/report.html", ""},
                                        "<svg id=\"s\"></svg>",
                                        "vir-slam rendezvous a.ini",
                                        {"robot B: few < ranges"},
                                        {"robot B cannot be placed"}});
  for (const char* part : {"vir-slam rendezvous a.ini</p>", "<li>robot B: few &lt; ranges</li>",
                           "<li>robot B cannot be placed</li>", "; first frame at "}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  // Anchors have a colour of their own.
  EXPECT_EQ(html.find("\"color\":\"c" + std::to_string(kAnchorColor)), std::string::npos);
  EXPECT_NE(html.find("<a href=\"A/report.html\">"), std::string::npos);
  EXPECT_EQ(html.find("<b>"), std::string::npos) << "a name is no markup";
  const nlohmann::json found = probe(html, 1200);
  ASSERT_TRUE(found.is_object());
  EXPECT_EQ(found["wrong"], nlohmann::json::array());
  EXPECT_EQ(found["still_hidden"], true);
  EXPECT_LE(found["wide"].get<double>(), 0);
  const int in_space = found["in_space"];
  EXPECT_GE(found["canvases"], 4 + 2 * in_space) << "map, space and its names, yaw and offset";
  EXPECT_GE(found["moved_by_slider"], 4 + in_space);
  EXPECT_GE(found["zoomed_charts"], 4);
  EXPECT_EQ(found["after_event"], 2);
}

TEST_F(Page, AFailedRunHasAPageToo) {
  summary_.longest_wait_reason = "too little parallax";
  const nlohmann::json found = probe(pageOfTheRun(), 1200);
  ASSERT_TRUE(found.is_object());
  EXPECT_EQ(found["wrong"], nlohmann::json::array());
}

}  // namespace
}  // namespace vir::results
