/// DDS Security with certificates made here.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <thread>

#include "cyclone/cyclone_link.h"
#include "program.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir::dds {
namespace {

std::vector<std::string> robot(int number, const std::string& security) {
  std::vector<std::string> out{
      std::to_string(number), std::to_string(test::ownDomain()), "team", "100000", "50", ""};
  if (!security.empty()) out.push_back(security);
  return out;
}

TEST(Security, WhoHasNoCertificateOfTheTeamIsNeitherHeardNorTold) {
  if (test::shell("command -v openssl").code == 1) GTEST_SKIP() << "openssl is not installed";
  const test::TempFolder folder;
  const std::string ours = (folder / "ours").string(), theirs = (folder / "theirs").string();
  const std::string make = test::sourceDir() + "/tests/unit/dds/make_enclaves.sh ";
  const test::Outcome made = test::shell(make + ours + " a b && " + make + theirs + " c");
  ASSERT_EQ(made.code, 0) << made.text;
  LinkOptions options;
  options.domain = test::ownDomain();
  options.team = "team";
  options.security = ours + "/a";
  const auto link = openCycloneLink(options);
  const test::Program mate("vir_test_dds_robot", robot(5, ours + "/b"));
  const test::Program stranger("vir_test_dds_robot", robot(6, theirs + "/c"));
  const test::Program plain("vir_test_dds_robot", robot(7, ""));
  std::map<std::uint32_t, int> heard;
  // Until long after the mate has been heard.
  for (int i = 0; i < 2000 && heard[5] < 200; ++i) {
    for (const team::PeerReport& r : link->take()) ++heard[r.robot];
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(heard[5], 200);
  EXPECT_EQ(heard.count(6) + heard.count(7), 0u);
  EXPECT_EQ(link->listeners(), 1);
}

}  // namespace
}  // namespace vir::dds
