#include "dwm1001_parser.h"

#include <algorithm>

#include "text_scanner.h"

namespace vir::uwb {
namespace {

constexpr std::int64_t kMaxAnchors = 15;  // more than a tag ever ranges to in one go
constexpr std::size_t kDecimals = 2;

bool position(TextScanner* s) {
  double v = 0;
  return s->fixed(kDecimals, &v) && s->literal(',') && s->fixed(kDecimals, &v) && s->literal(',') &&
         s->fixed(kDecimals, &v);
}

bool positionAndQuality(TextScanner* s) {
  std::int64_t quality = 0;
  return position(s) && s->literal(',') && s->integer(&quality) && quality >= 0 && quality <= 100;
}

}  // namespace

bool Dwm1001Parser::addAnchor(std::int64_t id, double range_m) {
  const bool again = std::any_of(found_.begin(), found_.end(),
                                 [id](const RangeReading& r) { return r.responder == id; });
  RangeReading reading;
  reading.responder = id;
  reading.range_m = range_m;
  found_.push_back(reading);
  return !again && range_m >= 0;
}

bool Dwm1001Parser::parseLec(TextScanner* s) {
  std::int64_t count = 0, index = 0, id = 0;
  double range_m = 0;
  if (!s->integer(&count) || count < 0 || count > kMaxAnchors) return false;
  for (std::int64_t i = 0; i < count; ++i) {
    if (!s->literal(",AN") || !s->integer(&index) || index != i || !s->literal(',') ||
        !s->hex(4, 4, &id) || !s->literal(',') || !position(s) || !s->literal(',') ||
        !s->fixed(kDecimals, &range_m) || !addAnchor(id, range_m)) {
      return false;
    }
  }
  if (s->atEnd()) return true;
  return s->literal(",POS,") && positionAndQuality(s) && s->atEnd();
}

bool Dwm1001Parser::parseLes(TextScanner* s) {
  std::int64_t id = 0, microseconds = 0;
  double range_m = 0;
  while (!s->atEnd() && !s->peek("le_us=") && !s->peek("est[")) {
    if (!s->hex(4, 4, &id) || !s->literal('[') || !position(s) || !s->literal("]=") ||
        !s->fixed(kDecimals, &range_m) || !addAnchor(id, range_m)) {
      return false;
    }
    if (!s->atEnd() && !s->literal(' ')) return false;
  }
  if (found_.empty() || found_.size() > kMaxAnchors) return false;
  if (s->literal("le_us=") && (!s->integer(&microseconds) || microseconds < 0)) return false;
  s->blanks();
  if (s->atEnd()) return true;
  return s->literal("est[") && positionAndQuality(s) && s->literal(']') && s->atEnd();
}

LineRangeParser::Verdict Dwm1001Parser::parseLine(std::string_view line,
                                                  std::vector<RangeReading>* out) {
  while (line.substr(0, 5) == "dwm> ") line.remove_prefix(5);
  while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
  TextScanner s(line);
  std::int64_t id = 0;
  TextScanner probe(line);
  const bool lec = s.literal("DIST,");
  const bool les = !lec && probe.hex(4, 4, &id) && probe.peek("[");
  if (!lec && !les) {
    const bool torn = line.find("DIST,") != line.npos || line.find(",AN") != line.npos ||
                      line.find("]=") != line.npos;
    return torn ? Verdict::corrupt : Verdict::other;
  }
  found_.clear();
  if (!(lec ? parseLec(&s) : parseLes(&s))) return Verdict::corrupt;
  for (const RangeReading& reading : found_) give(reading, out);
  return Verdict::message;
}

}  // namespace vir::uwb
