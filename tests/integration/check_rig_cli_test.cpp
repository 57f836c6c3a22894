/// `vir-slam check` of recordings whose second camera has a fault, beside a first that is fine.
#include <gtest/gtest.h>

#include "vir_test_data.h"
#include "vir_test_variant.h"

namespace {

using vir::test::check;
using vir::test::Checked;
using vir::test::contains;
using vir::test::has;
using vir::test::quoted;
using vir::test::Row;
using vir::test::Variant;
using vir::test::virSlam;

constexpr const char* kFlight = "euroc_MH01_clip30s";
constexpr const char* kNone = "`[Estimator] other_cameras = none`";

TEST(CheckRigCli, ASecondCameraOnAnotherClockLeavesTheRecordingUsable) {
  VIR_REQUIRE_DATA(source, kFlight);
  const Variant v(source, 6);
  long long first = 0;
  v.rewrite("cam1", "#t", [&](const Row& r) {
    if (first == 0) first = r.t;
    return Variant::line(r.t - first + 100'000'000'000, r.rest);
  });
  const Checked c = check(v);
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, std::vector<std::string>{"no_overlap"}) << c.text;
  EXPECT_TRUE(contains(c.text, kNone)) << c.text;
  EXPECT_TRUE(contains(c.text, "CAM0: its clock against the gyro's")) << "the rest is looked at";
  // By default a run leaves it alone, and so does its verdict.
  const auto run = virSlam("run " + v.folder() + " --out " + quoted(v.out("run")));
  EXPECT_EQ(run.code, 0) << run.text;
  const auto summary = nlohmann::json::parse(vir::test::readText(v.out("run") + "/summary.json"));
  EXPECT_EQ(summary["verdict"], "good") << run.text;
  EXPECT_TRUE(summary["doubts"].empty()) << summary["doubts"];
}

TEST(CheckRigCli, ASecondCameraThatHangsOrLacksImagesIsNamed) {
  VIR_REQUIRE_DATA(source, kFlight);
  const Variant frozen(source, 10);
  std::string held;
  int i = 0;
  frozen.rewrite("cam1", "#t", [&](const Row& r) {
    if (++i == 100) held = r.rest;
    return Variant::line(r.t, i > 100 && i < 180 ? held : r.rest);
  });
  const Checked hangs = check(frozen);
  EXPECT_EQ(hangs.code, 3) << hangs.text;
  EXPECT_EQ(hangs.kinds, std::vector<std::string>{"frozen"}) << hangs.text;
  EXPECT_TRUE(contains(hangs.text, "doubtful: CAM1: the same image comes again and again"));
  // Listed, and every third not there.
  const Variant missing(source, 6);
  missing.rewrite("cam1", "#t", [&](const Row& r) {
    return Variant::line(r.t, ++i % 3 == 0 ? ",no.jpg" : r.rest);
  });
  const Checked lacks = check(missing);
  EXPECT_EQ(lacks.code, 3) << lacks.text;
  EXPECT_TRUE(has(lacks, "images_missing")) << lacks.text;
}

/// The second camera's T_BS, `times` as far from the first (whose place is given too) as it is.
void moveSecond(const Variant& v, double times) {
  const auto pose = [&](const std::string& camera) {
    const std::string text = vir::test::readText((v.mav0() / camera / "sensor.yaml").string());
    const std::size_t from = text.find('[', text.find("data:")) + 1;
    std::istringstream in(text.substr(from, text.find(']', from) - from));
    std::vector<double> out;
    for (std::string number; std::getline(in, number, ',');) out.push_back(std::stod(number));
    return std::make_pair(text, out);
  };
  const auto first = pose("cam0").second;
  auto [text, second] = pose("cam1");
  std::ostringstream data;
  data << std::setprecision(12);
  for (std::size_t i = 0; i < 16; ++i) {
    const bool place = i % 4 == 3 && i < 12;
    data << (i > 0 ? ", " : "") << (place ? first[i] + times * (second[i] - first[i]) : second[i]);
  }
  const std::size_t from = text.find('[', text.find("data:")) + 1;
  text.replace(from, text.find(']', from) - from, data.str());
  const auto file = v.mav0() / "cam1/sensor.yaml";
  std::filesystem::remove(file);
  vir::test::writeText(file, text);
}

TEST(CheckRigCli, ASecondCameraElsewhereThanTheCalibrationSaysIsNamed) {
  VIR_REQUIRE_DATA(source, kFlight);
  for (const auto& [times, kind] : {std::pair<double, const char*>{1.3, "rig_length"},
                                    {-1, "rig_mirrored"},
                                    {0, "rig_same_place"}}) {
    const Variant v(source, 10);
    v.rewrite("cam1", "#t", [](const Row& r) { return Variant::line(r.t, r.rest); });
    moveSecond(v, times);
    const Checked c = check(v);
    EXPECT_EQ(c.code, 3) << c.text;
    EXPECT_EQ(c.kinds, std::vector<std::string>{kind}) << c.text;
  }
}

TEST(CheckRigCli, ASecondCameraThatIsLateIsNamed) {
  VIR_REQUIRE_DATA(source, kFlight);
  const Variant v(source, 12);
  v.rewrite("cam1", "#t", [](const Row& r) { return Variant::line(r.t + 30'000'000, r.rest); });
  const Checked c = check(v);
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, std::vector<std::string>{"time_offset"}) << c.text;
  EXPECT_TRUE(contains(c.text, "doubtful: CAM1: its images are stamped 3")) << c.text;
  EXPECT_TRUE(contains(c.text, "--set \"Camera.other_time_offsets_s=-0.03")) << c.text;
}

}  // namespace
