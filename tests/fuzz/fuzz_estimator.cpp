/// The whole estimator on a flight that the bytes disturb: no crash, no hang, no state that is no
/// number.
///   fuzz_estimator -max_len=512 -max_total_time=60
#include <cstdio>
#include <cstdlib>

#include "fuzz_damage.h"
#include "vir_test_random_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vir::fuzz::count(size);
  const std::string problem = vir::test::RandomInput(data, size).run();
  if (!problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    std::abort();
  }
  return 0;
}
