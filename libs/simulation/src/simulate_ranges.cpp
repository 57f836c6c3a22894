#include "vir/simulation/simulate_ranges.h"

#include <algorithm>

#include "range_channel.h"
#include "vir/simulation/interval.h"

namespace vir::simulation {

Vec3 anchorAt(const RangeSimulationOptions& o, std::size_t index, double s) {
  Vec3 p(o.anchor_m.at(3 * index), o.anchor_m.at(3 * index + 1), o.anchor_m.at(3 * index + 2));
  for (std::size_t k = 0; k + 5 <= o.jump.size(); k += 5) {
    if (o.jump[k] == static_cast<double>(index) && s >= o.jump[k + 1]) {
      p = Vec3(o.jump[k + 2], o.jump[k + 3], o.jump[k + 4]);
    }
  }
  return p;
}

std::vector<SimulatedRange> simulateRanges(const Motion& motion, const RangeSimulationOptions& o,
                                           const rendering::Scene* scene) {
  checkRangeOptions(o);
  const Vec3 lever(o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]);
  const double period = 1 / o.rate_hz;
  std::vector<SimulatedRange> out;
  for (std::size_t a = 0; 3 * a < o.anchor_m.size(); ++a) {
    RangeChannel channel(o, 200 + a, scene);
    double last = 0;
    for (int slot = 0;; ++slot) {
      // Half a period of offset: a negative jitter must not reach before the first pose.
      const double s = (slot + 0.5 + channel.jitter()) * period;
      const TimeNs t = motion.begin() + fromSeconds(s);
      if (t > motion.end()) break;
      SimulatedRange r = channel.measure(motion.poseAt(t) * lever, anchorAt(o, a, s), s - last);
      last = s;
      r.t = t;
      r.anchor = anchorId(o, a);
      if (channel.lost() || insideAny(o.outage_s, s)) continue;
      out.push_back(r);
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const SimulatedRange& x, const SimulatedRange& y) { return x.t < y.t; });
  return out;
}

std::vector<SimulatedRange> simulateRangeDifferences(const Motion& motion,
                                                     const RangeSimulationOptions& o,
                                                     const rendering::Scene* scene) {
  checkRangeOptions(o);
  const Vec3 lever(o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]);
  const double period = 1 / o.rate_hz;
  const std::size_t count = o.anchor_m.size() / 3;
  std::vector<SimulatedRange> out;
  for (std::size_t a = 0; count > 1 && a < count; ++a) {
    const std::size_t before = (a + count - 1) % count;
    RangeChannel to(o, 400 + a, scene), from(o, 600 + a, scene);
    double last = 0;
    for (int slot = 0;; ++slot) {
      const double s = (slot + 0.5 + to.jitter()) * period;
      const TimeNs t = motion.begin() + fromSeconds(s);
      if (t > motion.end()) break;
      const Vec3 antenna = motion.poseAt(t) * lever;
      SimulatedRange r = to.measure(antenna, anchorAt(o, a, s), s - last);
      const SimulatedRange reference = from.measure(antenna, anchorAt(o, before, s), s - last);
      last = s;
      if (to.lost() || from.lost() || insideAny(o.outage_s, s)) continue;
      r.t = t;
      r.anchor = anchorId(o, a);
      r.reference = anchorId(o, before);
      r.range_m -= reference.range_m;
      r.true_m -= reference.true_m;
      r.line_of_sight = r.line_of_sight && reference.line_of_sight;
      out.push_back(r);
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const SimulatedRange& x, const SimulatedRange& y) { return x.t < y.t; });
  return out;
}

}  // namespace vir::simulation
