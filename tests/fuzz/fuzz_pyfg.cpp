/// Any bytes, or damage to a good graph, as PyFG text: finite events in the order of time, or
/// InputError or SettingsError.
///   VIR_FUZZ_BYTES=10000000 fuzz_pyfg -max_len=256
#include <cmath>

#include "fuzz_damage.h"
#include "fuzz_folder.h"
#include "fuzz_memory.h"
#include "input_error.h"
#include "robot_recording.h"
#include "vir/core/settings.h"
#include "vir_test_pyfg.h"

namespace {

using namespace vir::pyfg;

std::string goodFile() {
  std::string text = vir::test::twoRobots(6);
  for (int i = 0; i < 4; ++i) {
    const std::string a = "A" + std::to_string(i), b = "A" + std::to_string(i + 1);
    text += "VERTEX_SE3:QUAT 5" + std::to_string(i) + " " + a + " 1 2 3 0 0 0.6 0.8\n";
    text += "EDGE_SE3:QUAT 5" + std::to_string(i + 1) + " " + a + " " + b + " 1 0 0 0 0 0 1 " +
            vir::test::kSpatialCovariance + "\n";
  }
  return text;
}

void check(const RobotRecording& r) {
  vir::TimeNs last = 0;
  for (const Event& e : r.events) {
    if (e.t < last) std::abort();
    last = e.t;
    if (const auto* p = std::get_if<TruePose>(&e.what)) {
      if (!p->T_W_B.p.allFinite()) std::abort();
    }
    if (const auto* o = std::get_if<OdometryPose>(&e.what)) {
      if (!o->T_O_B.p.allFinite() || !o->step_covariance.allFinite()) std::abort();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = goodFile();
  static const vir::fuzz::Folder folder;
  const std::string text = vir::fuzz::input(data, size, good);
  folder.write("g.pyfg", text);
  {
    // A line of 20 letters is an edge with a covariance of 36 numbers.
    const vir::fuzz::MemoryWatch watch(text.size(), 40, 2 << 20);
    try {
      vir::ProblemLog log;
      PyfgOptions options;
      options.robot = "A";
      check(extractRobot(readGraph((folder.path() / "g.pyfg").string(), &log), options, &log));
    } catch (const vir::InputError&) {
    } catch (const vir::SettingsError&) {
    }
  }
  vir::fuzz::count(text.size());
  return 0;
}
