/// Observations of which MRPT keeps the classes in libraries that we are not linked to.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <mrpt/rtti/CObject.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

/// What a laser scanner's driver would write between two images, by a process that has the class.
void writeWith(const std::string& module, const std::string& class_name, const std::string& file) {
  Dl_info obs{};
  if (dladdr(reinterpret_cast<void*>(&mrpt::obs::CObservation::GetRuntimeClassIdStatic), &obs) ==
      0) {
    _exit(4);
  }
  std::string library = obs.dli_fname;
  library.replace(library.rfind("obs."), 3, module);
  if (dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL) == nullptr) _exit(2);
  const auto object = mrpt::rtti::classFactory(class_name);
  const auto other = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object);
  if (!other) _exit(3);
  other->sensorLabel = "OTHER";
  other->timestamp = test::imageAt(test::kStart + 1)->timestamp;
  RawlogWriter writer(file);
  writer.write(*test::imageAt(test::kStart));
  writer.write(*other);
  writer.write(*test::imageAt(test::kStart + 2));
  writer.finish();
  _exit(0);
}

class MoreClasses : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(MoreClasses, AreReadThoughNothingIsLinkedToTheirLibrary) {
  const auto [module, class_name] = GetParam();
  if (mrpt::rtti::findRegisteredClass(class_name) != nullptr) {
    GTEST_SKIP() << class_name << " is known in this process already";
  }
  const test::TempFolder folder;
  const std::string file = (folder / "other.rawlog").string();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) writeWith(module, class_name, file);
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0);
  ASSERT_EQ(mrpt::rtti::findRegisteredClass(class_name), nullptr);

  RawlogReader reader(file);
  std::vector<std::string> labels;
  while (const auto o = reader.next()) labels.push_back(o->sensorLabel);
  EXPECT_EQ(reader.damage(), "");
  EXPECT_EQ(labels, (std::vector<std::string>{"CAM0", "OTHER", "CAM0"}));
}

// In this order: one that is linked to the others would bring their classes.
INSTANTIATE_TEST_SUITE_P(OfMrpt, MoreClasses,
                         testing::Values(std::pair{"maps", "mrpt::obs::CObservationPointCloud"},
                                         std::pair{"vision",
                                                   "mrpt::obs::CObservationVisualLandmarks"}));

}  // namespace
}  // namespace vir::rawlog
