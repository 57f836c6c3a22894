/// Any bytes, or damage to good settings, as an ini file: settings or SettingsError.
///   VIR_FUZZ_BYTES=10000000 fuzz_ini -max_len=256
#include "fuzz_damage.h"
#include "fuzz_memory.h"
#include "vir/core/settings.h"

namespace {

constexpr const char* kGood =
    "// a comment\n@define RATE 20\n[Camera]\nwidth = 752 ; px\nrate = ${RATE}\n"
    "fx = $eval{458.654*2}\nname = \"a b\" # why\n[Imu]\ngyro_noise_density = 1.7e-4 \\\n  \n"
    "axes = 1 0 0 \\\n 0 1 0\n[camera.more]\nhome = $env{HOME}\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = kGood;
  const std::string text = vir::fuzz::input(data, size, good);
  {
    // A value that names another may be as long as the bound on a value, however short its line.
    const vir::fuzz::MemoryWatch watch(text.size(), 40, 4 << 20);
    try {
      vir::Settings settings = vir::Settings::fromText(text, "fuzz");
      for (const vir::Setting& s : settings.all()) {
        if (settings.find(s.section, s.key) == nullptr) std::abort();
      }
      settings.set(text);
    } catch (const vir::SettingsError&) {
    }
  }
  vir::fuzz::count(text.size());
  return 0;
}
