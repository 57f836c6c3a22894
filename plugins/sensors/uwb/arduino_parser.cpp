#include "arduino_parser.h"

#include "text_scanner.h"

namespace vir::uwb {
namespace {

bool readLine(std::string_view line, RangeReading* r) {
  TextScanner s(line);
  double rssi = 0;
  if (!s.literal("from:")) return false;
  s.blanks();
  s.literal("0x");
  if (!s.hex(1, 4, &r->responder) || !s.peek("\t")) return false;
  s.blanks();
  if (!s.literal("Range:")) return false;
  s.blanks();
  if (!s.fixed(0, &r->range_m) || !s.literal(" m\t")) return false;
  s.blanks();
  if (!s.literal("RX power:")) return false;
  s.blanks();
  if (!s.fixed(0, &rssi) || !s.literal(" dBm")) return false;
  r->rssi_dbm = rssi;
  s.blanks();
  return s.atEnd();
}

}  // namespace

LineRangeParser::Verdict ArduinoParser::parseLine(std::string_view line,
                                                  std::vector<RangeReading>* out) {
  RangeReading reading;
  if (!readLine(line, &reading)) {
    return line.find("from:") != line.npos || line.find("Range:") != line.npos ? Verdict::corrupt
                                                                               : Verdict::other;
  }
  give(reading, out);
  return Verdict::message;
}

}  // namespace vir::uwb
