#include "batch/batch_columns.h"

#include "output/console.h"

namespace vir::app {
namespace {

using Maybe = std::optional<double>;

std::string cellText(const Maybe& v, int decimals) { return v ? fixed(*v, decimals) : "-"; }

}  // namespace

std::string titleOf(const BatchSetting& s) { return s.title.empty() ? s.name : s.title; }

const std::vector<BatchColumn>& batchColumns() {
  static const std::vector<BatchColumn> all{
      {"runs",
       [](const BatchCell& c) {
         std::string text = std::to_string(c.runs);
         if (c.failed > 0) text += " (" + std::to_string(c.failed) + " failed)";
         if (c.missing > 0) text += " (" + std::to_string(c.missing) + " missing)";
         return text;
       },
       false, true},
      {"ATE median [m]", [](const BatchCell& c) { return cellText(c.ate_median_m, 3); }, true,
       true},
      {"ATE worst [m]", [](const BatchCell& c) { return cellText(c.ate_worst_m, 3); }, false, true},
      {"smoothed [m]", [](const BatchCell& c) { return cellText(c.smoothed_median_m, 3); }},
      {"RPE 1 s [m]", [](const BatchCell& c) { return cellText(c.rpe_1s_m, 4); }},
      {"RPE 10 m [m]", [](const BatchCell& c) { return cellText(c.rpe_10m_m, 3); }},
      {"anchor [m]", [](const BatchCell& c) { return cellText(c.anchor_m, 2); }, false, true},
      {"NEES", [](const BatchCell& c) { return cellText(c.nees, 2); }},
      {"coverage [%]",
       [](const BatchCell& c) { return c.coverage ? fixed(100 * *c.coverage, 1) : "-"; }},
      {"first pose [s]", [](const BatchCell& c) { return cellText(c.init_s, 2); }, false, true},
      {"CPU [ms/image]", [](const BatchCell& c) { return cellText(c.cpu_ms, 1); }, false, true},
  };
  return all;
}

}  // namespace vir::app
