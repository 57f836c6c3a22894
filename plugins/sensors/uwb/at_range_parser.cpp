#include "at_range_parser.h"

#include "text_scanner.h"

namespace vir::uwb {
namespace {

constexpr std::string_view kHead = "AT+RANGE=";

struct Report {
  std::int64_t tag = 0, mask = 0;
  std::vector<std::int64_t> range_cm, anchors;
  std::vector<double> rssi_dbm;
};

bool comma(TextScanner* s) {
  if (!s->literal(',')) return false;
  s->blanks();
  return true;
}

/// "(a,b,c)" of at most 8 items.
template <typename T, typename Read>
bool list(TextScanner* s, std::vector<T>* items, Read read) {
  if (!s->literal('(')) return false;
  do {
    T item{};
    s->blanks();
    if (!read(s, &item)) return false;
    items->push_back(item);
  } while (items->size() < 8 && comma(s));
  return s->literal(')');
}

bool whole(TextScanner* s, std::int64_t* v) { return s->integer(v); }
bool decimal(TextScanner* s, double* v) { return s->number(v); }

bool readReport(std::string_view line, Report* r) {
  TextScanner s(line);
  std::int64_t sequence = 0;
  double position = 0;
  if (!s.literal(kHead) || !s.literal("tid:") || !s.integer(&r->tag) || r->tag < 0 || !comma(&s) ||
      !s.literal("mask:")) {
    return false;
  }
  s.literal("0x");
  if (!s.hex(1, 2, &r->mask) || !comma(&s) || !s.literal("seq:") || !s.integer(&sequence) ||
      sequence < 0 || !comma(&s) || !s.literal("range:") || !list(&s, &r->range_cm, whole)) {
    return false;
  }
  const std::size_t slots = r->range_cm.size();
  if ((slots != 4 && slots != 8) || r->mask >= (std::int64_t{1} << slots)) return false;
  // What may follow, in this order.
  if (s.atEnd()) return true;
  if (!comma(&s)) return false;
  bool more = true;
  if (s.literal("rssi:")) {
    if (!list(&s, &r->rssi_dbm, decimal) || r->rssi_dbm.size() != slots) return false;
    more = comma(&s);
  }
  if (more && s.literal("kx:")) {
    if (!s.number(&position) || !comma(&s) || !s.literal("ky:") || !s.number(&position)) {
      return false;
    }
    more = comma(&s);
  }
  if (more) {
    if (!s.literal("ancid:") || !list(&s, &r->anchors, whole) || r->anchors.size() != slots) {
      return false;
    }
  }
  s.blanks();
  return s.atEnd();
}

}  // namespace

LineRangeParser::Verdict AtRangeParser::parseLine(std::string_view line,
                                                  std::vector<RangeReading>* out) {
  Report report;
  if (!readReport(line, &report)) {
    return line.find("RANGE=") != line.npos || line.find("range:") != line.npos ? Verdict::corrupt
                                                                                : Verdict::other;
  }
  for (std::size_t i = 0; i < report.range_cm.size(); ++i) {
    const bool measured = ((report.mask >> i) & 1) != 0;
    if (!measured || (!report.anchors.empty() && report.anchors[i] < 0)) {
      ++counters_.failed;
      continue;
    }
    RangeReading reading;
    reading.responder = report.anchors.empty() ? static_cast<std::int64_t>(i) : report.anchors[i];
    reading.own = report.tag;
    reading.range_m = static_cast<double>(report.range_cm[i]) / 100;
    if (!report.rssi_dbm.empty()) reading.rssi_dbm = report.rssi_dbm[i];
    give(reading, out);
  }
  return Verdict::message;
}

}  // namespace vir::uwb
