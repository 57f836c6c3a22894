#include "trek1000_parser.h"

#include <algorithm>

#include "text_scanner.h"

namespace vir::uwb {
namespace {

/// Number of hexadecimal digits of the word at the front.
std::size_t wordLength(std::string_view text) { return std::min(text.find(' '), text.size()); }

struct Report {
  char kind = 0;  // c, r, a
  std::int64_t mask = 0, time_ms = 0, tag = 0;
  std::int64_t range_mm[8] = {};
  int slots = 0;
  std::optional<double> rssi_dbm;
};

/// 32 bits as they are printed with %08x: a negative number has its highest bit set.
std::int64_t signed32(std::int64_t v) {
  return v >= (std::int64_t{1} << 31) ? v - (std::int64_t{1} << 32) : v;
}

bool readRanges(TextScanner* s, Report* r) {
  std::int64_t v = 0;
  while (wordLength(s->rest()) == 8 && r->slots < 8) {
    if (!s->hex(8, 8, &v) || !s->literal(' ')) return false;
    r->range_mm[r->slots++] = signed32(v);
  }
  return (r->slots == 4 || r->slots == 8) && r->mask < (1 << r->slots);
}

bool readReport(std::string_view line, Report* r) {
  TextScanner s(line);
  std::int64_t log = 0, sequence = 0, delay = 0, other = 0;
  char role = 0;
  if (!s.literal('m') || !s.oneOf("cra", &r->kind) || !s.literal(' ') || !s.hex(2, 2, &r->mask) ||
      !s.literal(' ') || !readRanges(&s, r) || !s.hex(4, 4, &log) || !s.literal(' ') ||
      !s.hex(2, 2, &sequence) || !s.literal(' ')) {
    return false;
  }
  if (wordLength(s.rest()) == 8) {
    if (!s.hex(8, 8, &r->time_ms)) return false;
  } else if (r->kind == 'c' || !s.hex(4, 4, &delay) || !s.literal(' ') || !s.hex(4, 4, &delay)) {
    return false;
  }
  if (!s.literal(' ') || !s.oneOf("atc", &role) || !s.integer(&r->tag) || r->tag < 0 ||
      !s.literal(':') || !s.integer(&other) || other < 0 || r->tag > 0xFFFF || other > 0xFFFF) {
    return false;
  }
  if (s.literal(' ') && !s.atEnd()) {
    std::int64_t rssi = 0;
    if (!s.hex(4, 4, &rssi)) return false;
    r->rssi_dbm = static_cast<double>(rssi) / -100;
    s.blanks();
  }
  return s.atEnd();
}

}  // namespace

LineRangeParser::Verdict Trek1000Parser::parseLine(std::string_view line,
                                                   std::vector<RangeReading>* out) {
  const bool ours = line.size() > 3 && line[0] == 'm' && line[2] == ' ' &&
                    (line[1] == 'c' || line[1] == 'r' || line[1] == 'a');
  Report report;
  if (!readReport(line, &report)) {
    const bool torn = ours || line.find("mc ") != line.npos;
    return torn ? Verdict::corrupt : Verdict::other;
  }
  if (report.kind != 'c') return Verdict::ignored;
  for (int i = 0; i < report.slots; ++i) {
    if (((report.mask >> i) & 1) == 0) {
      ++counters_.failed;
      continue;
    }
    RangeReading reading;
    reading.responder = i;
    reading.own = report.tag;
    reading.range_m = static_cast<double>(report.range_mm[i]) / 1000;
    reading.rssi_dbm = report.rssi_dbm;
    reading.device_time = report.time_ms * 1000000;
    give(reading, out);
  }
  return Verdict::message;
}

}  // namespace vir::uwb
