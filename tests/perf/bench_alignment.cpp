/// How long an answer to "where is the other robot's world" takes.
#include <benchmark/benchmark.h>

#include "meetings.h"

namespace vir {
namespace {

void twoRangesAndAnchor(benchmark::State& state) {
  test::Meeting m;
  m.rate_hz = 0.2;
  m.ranges = 2;
  const auto made = test::meet(m, 5);
  const team::TransformOptions options;
  for (auto _ : state) {
    benchmark::DoNotOptimize(team::findTransform(made.ranges, made.anchors, options));
  }
}
BENCHMARK(twoRangesAndAnchor)->Unit(benchmark::kMicrosecond);

void manyRanges(benchmark::State& state, bool anchor) {
  test::Meeting m;
  m.ranges = static_cast<int>(state.range(0));
  m.nlos = 0.3;
  m.position_sigma_m = 0.05;
  auto made = test::meet(m, 5);
  if (!anchor) made.anchors.clear();
  const team::TransformOptions options;
  for (auto _ : state) {
    benchmark::DoNotOptimize(team::findTransform(made.ranges, made.anchors, options));
  }
}
BENCHMARK_CAPTURE(manyRanges, with_anchor, true)
    ->Arg(10)
    ->Arg(100)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(manyRanges, without_anchor, false)
    ->Arg(10)
    ->Arg(100)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vir

BENCHMARK_MAIN();
