#pragma once
/// Qorvo DWM1001 (PANS firmware), output of the shell commands `lec` and `les`:
///   DIST,2,AN0,022E,7.94,8.03,0.00,3.44,AN1,15BA,0.00,8.00,0.00,2.12,POS,6.95,5.37,-1.97,52
///   022E[7.94,8.03,0.00]=3.38 15BA[0.00,8.00,0.00]=2.12 le_us=3082 est[6.95,5.37,-1.97,52]
/// per anchor name, id (4 hex digits), position and range [m]; position of the tag and its quality,
/// where it has one. There is no checksum and at high rates lines get mixed: a line counts only if
/// all of it is as it must be, with two decimals everywhere and no anchor twice.
#include <cstdint>

#include "range_parser.h"

namespace vir {
class TextScanner;
}

namespace vir::uwb {

class Dwm1001Parser : public LineRangeParser {
 public:
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "dwm1001"; }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;

 private:
  bool parseLec(TextScanner* s);
  bool parseLes(TextScanner* s);
  bool addAnchor(std::int64_t id, double range_m);

  std::vector<RangeReading> found_;
};

}  // namespace vir::uwb
