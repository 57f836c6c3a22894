#include "range_parser.h"

#include <algorithm>
#include <cmath>

namespace vir::uwb {

ParserCounters& ParserCounters::operator+=(const ParserCounters& o) {
  messages += o.messages;
  ranges += o.ranges;
  failed += o.failed;
  implausible += o.implausible;
  corrupt += o.corrupt;
  fragments += o.fragments;
  ignored += o.ignored;
  other_text += o.other_text;
  device_errors += o.device_errors;
  skipped_bytes += o.skipped_bytes;
  return *this;
}

void RangeParser::give(const RangeReading& reading, std::vector<RangeReading>* out) {
  // A difference may be 0, and is no longer than a range.
  const double least_m = reading.reference ? -limits_.max_m : limits_.min_m;
  if (reading.range_m == 0 && !reading.reference) {
    ++counters_.failed;
  } else if (!(reading.range_m >= least_m && reading.range_m <= limits_.max_m)) {
    ++counters_.implausible;
  } else {
    ++counters_.ranges;
    out->push_back(reading);
  }
}

namespace {

bool isText(std::string_view line) {
  return std::all_of(line.begin(), line.end(),
                     [](char c) { return c == '\t' || (c >= ' ' && c <= '~'); });
}

}  // namespace

void LineRangeParser::feed(const std::uint8_t* bytes, std::size_t size,
                           std::vector<RangeReading>* out) {
  batch_.clear();
  lines_.feed(bytes, size, &batch_);
  for (const LineAssembler::Line& line : batch_) {
    const bool readable = !line.too_long && isText(line.text);
    const Verdict verdict = readable ? parseLine(line.text, out) : Verdict::corrupt;
    switch (verdict) {
      case Verdict::message:
        ++counters_.messages;
        break;
      case Verdict::ignored:
        ++counters_.messages;
        ++counters_.ignored;
        break;
      case Verdict::other:
        ++counters_.other_text;
        break;
      case Verdict::device_error:
        ++counters_.device_errors;
        break;
      case Verdict::corrupt:
        ++(line.fragment ? counters_.fragments : counters_.corrupt);
        break;
      case Verdict::unfinished:
        break;
    }
  }
}

}  // namespace vir::uwb
