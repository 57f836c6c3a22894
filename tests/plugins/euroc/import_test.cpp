/// `vir-slam import` as a user calls it.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "vir/ranging/survey_table.h"
#include "vir_test_data.h"
#include "vir_test_euroc_folder.h"
#include "vir_test_shell.h"

namespace vir {
namespace {

namespace fs = std::filesystem;

using test::Outcome;
using test::virSlam;

std::map<std::string, int> countByLabel(const fs::path& rawlog) {
  std::map<std::string, int> counts;
  mrpt::io::CFileGZInputStream in(rawlog.string());
  auto archive = mrpt::serialization::archiveFrom(in);
  for (;;) {
    try {
      const auto object = archive.ReadObject();
      ++counts[dynamic_cast<const mrpt::obs::CObservation&>(*object).sensorLabel];
    } catch (const mrpt::serialization::CExceptionEOF&) {
      return counts;
    }
  }
}

class Import : public ::testing::Test {
 protected:
  Outcome run(const std::string& more = "") {
    return virSlam("import euroc " + folder.root().string() + " --out " + rawlog().string() + " " +
                   more);
  }
  fs::path rawlog() const { return folder.temp() / "out" / "x.rawlog"; }
  fs::path images() const { return folder.temp() / "out" / "x_Images"; }
  /// Names in the output folder, sorted, joined.
  std::string listing() const {
    std::string out;
    std::set<std::string> names;
    if (fs::exists(rawlog().parent_path())) {
      for (const auto& e : fs::directory_iterator(rawlog().parent_path())) {
        names.insert(e.path().filename().string());
      }
    }
    for (const auto& n : names) out += n + " ";
    return out;
  }
  test::EurocFolder folder;
};

TEST_F(Import, RangesBetweenAnchorsHaveTheLabelOfTheOneThatMeasured) {
  std::string text = "#timestamp,from,to,range\n";
  for (int i = 0; i < 6; ++i) {
    text += std::to_string(folder.imageStamp(i)) + (i % 3 == 0 ? ",4,5" : ",5,6") + ",7.25\n";
  }
  folder.write("uwb0/anchor_ranges.csv", text);
  const Outcome outcome = run();
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  auto counts = countByLabel(rawlog());
  EXPECT_EQ(counts["ANCHOR:4"], 2) << outcome.text;
  EXPECT_EQ(counts["ANCHOR:5"], 4) << outcome.text;
  EXPECT_GT(counts["UWB0"], 0) << outcome.text;
}

TEST_F(Import, WritesRawlogImagesAndNoise) {
  const Outcome o = run();
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(listing(), "x.ini x.rawlog x_Images ");
  const auto counts = countByLabel(rawlog());
  EXPECT_EQ(counts,
            (std::map<std::string, int>{
                {"CAM0", 10}, {"GT", folder.imuRows()}, {"IMU0", folder.imuRows()}, {"UWB0", 10}}));
  const fs::path first = images() / ("CAM0_" + std::to_string(folder.imageStamp(0)) + ".png");
  EXPECT_TRUE(fs::is_symlink(first));
  EXPECT_FALSE(cv::imread(first.string()).empty());
  EXPECT_NE(test::readText(folder.temp() / "out/x.ini").find("acc_random_walk = 0.003"),
            std::string::npos);
  EXPECT_EQ(o.text.find('\r'), std::string::npos) << "a progress bar in a log file";
  EXPECT_NE(o.text.find("CAM0"), std::string::npos);
}

TEST_F(Import, DrawnRangesLeaveTheirAnchorsBeside) {
  const Outcome o =
      run("--set euroc.simulate_ranges=true --set \"euroc.anchor_m=1 2 3 4 5 6.5\" "
          "--set \"euroc.anchor_id=4 9\"");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(test::readText(folder.temp() / "out/x_anchors_truth.csv"),
            "#id,x,y,z in the ground truth's frame [m]\n4,1,2,3\n9,4,5,6.5\n");
  ASSERT_EQ(run().code, 0);
  EXPECT_EQ(listing(), "x.ini x.rawlog x_Images ") << "drawn no longer";
}

TEST_F(Import, TakesTheTrueAnchorsOfTheRecordingAlong) {
  test::writeText(folder.mav0() / "uwb0/anchors_truth.csv",
                  "#id,x,y,z\n3,1,2,3\n4,nan,2,3\nfour,1,2,3\n");
  const Outcome o = run();
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(test::readText(folder.temp() / "out/x_anchors_truth.csv"),
            "#id,x,y,z in the ground truth's frame [m]\n3,1,2,3\n1000000,1,2,3\n")
      << "a name is a number in the rawlog";
  EXPECT_NE(o.text.find("anchors_truth.csv:3"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("anchor_not_finite"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("anchor four is 1000000"), std::string::npos) << o.text;
}

TEST_F(Import, LeavesATableOfTheAnchorsWhosePlacesTheRangesTell) {
  std::string table = "timestamp,anchor_id,range,anchor_x,anchor_y,anchor_z\n";
  for (int i = 0; i < 10; ++i) {
    table += std::to_string(folder.imageStamp(i)) +
             (i % 2 == 0 ? ",7,2.5,1,-2,3.25" : ",north,3.5,4,5,6") + "\n";
  }
  test::writeText(folder.mav0() / "uwb0/data.csv", table);
  const Outcome o = run();
  ASSERT_EQ(o.code, 0) << o.text;
  const std::string path = (folder.temp() / "out/x_anchors.csv").string();
  const std::string written = test::readText(path);
  EXPECT_EQ(written, "#id,x,y,z as the recording tells [m]\n7,1,-2,3.25\n1000000,4,5,6\n");
  EXPECT_NE(o.text.find("vir-slam run " + rawlog().string() + " --anchors " + path),
            std::string::npos)
      << o.text;
  const std::vector<SurveyedAnchor> survey = ranging::surveyFromText(written, path, {});
  ASSERT_EQ(survey.size(), 2u);
  EXPECT_EQ(survey[0].id, 7u);
  EXPECT_EQ(survey[0].p_S, Vec3(1, -2, 3.25));
  EXPECT_EQ(survey[1].id, 1000000u);
}

TEST_F(Import, TwiceGivesTheSameBytes) {
  ASSERT_EQ(run("--set euroc.images=embed").code, 0);
  const std::string first = test::readText(rawlog());
  ASSERT_EQ(run("--set euroc.images=embed").code, 0);
  EXPECT_EQ(test::readText(rawlog()), first);
}

TEST_F(Import, ReplacesAnOlderImportAsAWhole) {
  ASSERT_EQ(run().code, 0);
  ASSERT_EQ(run("--set euroc.max_duration_s=0.1").code, 0);
  EXPECT_EQ(countByLabel(rawlog())["CAM0"], 3);
  EXPECT_EQ(std::distance(fs::directory_iterator(images()), fs::directory_iterator()), 3);
  ASSERT_EQ(run("--set euroc.images=embed").code, 0);
  EXPECT_EQ(listing(), "x.ini x.rawlog ");
}

TEST_F(Import, AFailureLeavesTheOlderImportAlone) {
  ASSERT_EQ(run().code, 0);
  const std::string before = test::readText(rawlog());
  fs::rename(folder.mav0() / "cam0/data", folder.mav0() / "cam0/gone");
  const Outcome o = run();
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.text.find("no image"), std::string::npos) << o.text;
  EXPECT_EQ(test::readText(rawlog()), before);
  EXPECT_EQ(listing(), "x.ini x.rawlog x_Images ");
}

TEST_F(Import, ForeignFilesInTheImageFolderAreNotTouched) {
  test::writeText(images() / "holiday.png", "x");
  const Outcome o = run();
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.text.find("holiday.png"), std::string::npos) << o.text;
  EXPECT_EQ(test::readText(images() / "holiday.png"), "x");
}

TEST_F(Import, AnIniOfTheUserIsLeftAlone) {
  test::writeText(folder.temp() / "out/x.ini", "[Estimator]\n");
  const Outcome o = run();
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(test::readText(folder.temp() / "out/x.ini"), "[Estimator]\n");
  EXPECT_NE(o.text.find("left as it is"), std::string::npos) << o.text;
}

TEST_F(Import, ErrorsLeaveNothingBehind) {
  fs::remove(folder.mav0() / "cam0/sensor.yaml");
  const Outcome o = run();
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.text.find("cam0/sensor.yaml"), std::string::npos) << o.text;
  EXPECT_EQ(listing(), "");
}

TEST_F(Import, WrongUseIsExitCode2) {
  EXPECT_EQ(run("--set euroc.imges=link").code, 2);
  EXPECT_EQ(run("--set euroc.start_s=soon").code, 2);
  EXPECT_EQ(run("--set nonsense").code, 2);
  EXPECT_EQ(virSlam("import nosuch " + folder.root().string() + " --out " + rawlog().string()).code,
            2);
  EXPECT_EQ(virSlam("import euroc /nonexistent --out " + rawlog().string()).code, 2);
  EXPECT_EQ(virSlam("import euroc").code, 2);
  EXPECT_EQ(virSlam("import euroc " + folder.root().string() + " --out " +
                    (folder.temp() / "out/x.ini").string())
                .code,
            2);
  EXPECT_EQ(listing(), "");
}

TEST_F(Import, ProblemsAreReported) {
  folder.append("imu0/data.csv", "1403636590000000000,nan,0,0,0,0,9.81\n");
  fs::remove(folder.imageFile(3));
  const Outcome o = run();
  EXPECT_EQ(o.code, 0);
  EXPECT_NE(o.text.find("imu_not_finite"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("data.csv:93: column 2 is nan"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("image_missing"), std::string::npos) << o.text;
}

TEST(ImportShared, TheMachineHallClip) {
  VIR_REQUIRE_DATA(clip, "euroc_MH01_clip30s");
  test::TempFolder temp;
  const Outcome o =
      virSlam("import euroc " + clip.string() + " --out " + (temp / "mh.rawlog").string());
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(
      countByLabel(temp / "mh.rawlog"),
      (std::map<std::string, int>{{"CAM0", 600}, {"CAM1", 339}, {"GT", 6975}, {"IMU0", 7192}}));
  EXPECT_EQ(std::distance(fs::directory_iterator(temp / "mh_Images"), fs::directory_iterator()),
            939);
}

/// One image of a hundred and more that cannot be decoded is a slip, one of a hundred is not.
TEST(Check, UndecodableImagesAreDoubtfulFromOnePercentOn) {
  for (const int images : {101, 102}) {
    test::EurocFolderOptions o;
    o.images = images;
    const test::EurocFolder folder(o);
    test::writeText(folder.imageFile(50), "no image");
    const fs::path json = folder.temp() / "check.json";
    virSlam("check " + folder.root().string() + " --json " + json.string());
    std::string severity;
    const auto report = nlohmann::json::parse(test::readText(json));
    for (const auto& f : report["findings"]) {
      if (f["kind"] == "unreadable") severity += f["severity"].get<std::string>() + " ";
    }
    // 100 are left of 101, so that one is a hundredth of them.
    EXPECT_EQ(severity, images == 101 ? "doubtful " : "note ") << report["findings"];
  }
}

/// Newest first, as a logger's export may be: most rows come too late to be used.
TEST(Check, ATableInReverseOrderIsNamed) {
  test::EurocFolderOptions o;
  o.images = 101;
  const test::EurocFolder folder(o);
  std::istringstream in(folder.read("imu0/data.csv"));
  std::string header, reversed;
  std::getline(in, header);
  for (std::string line; std::getline(in, line);) reversed = line + "\n" + reversed;
  folder.write("imu0/data.csv", header + "\n" + reversed);
  const fs::path json = folder.temp() / "check.json";
  virSlam("check " + folder.root().string() + " --json " + json.string());
  const auto report = nlohmann::json::parse(test::readText(json));
  EXPECT_TRUE(std::any_of(report["findings"].begin(), report["findings"].end(), [](const auto& f) {
    return f["kind"] == "not_in_order" && f["severity"] == "doubtful";
  })) << report["findings"];
}

}  // namespace
}  // namespace vir
