#include "qm33_parser.h"

#include "text_scanner.h"

namespace vir::uwb {
namespace {

constexpr std::string_view kHead = "SESSION_INFO_NTF:";
constexpr std::int64_t kMaxItems = 32;

/// name=whole number, name as given.
bool field(TextScanner* s, std::string_view name, std::int64_t* value) {
  s->blanks();
  return s->literal(name) && s->literal('=') && s->integer(value) && *value >= 0;
}

bool isNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '[' || c == ']' || c == '/';
}

std::string_view takeName(TextScanner* s) {
  const std::string_view rest = s->rest();
  std::size_t n = 0;
  while (n < rest.size() && isNameCharacter(rest[n])) ++n;
  s->literal(rest.substr(0, n));
  return rest.substr(0, n);
}

/// "TEXT": capitals, digits and underscores.
bool takeQuoted(TextScanner* s, std::string_view* text) {
  if (!s->literal('"')) return false;
  *text = takeName(s);
  return !text->empty() && s->literal('"');
}

/// The value of a field that is not used: quoted, hexadecimal or a number.
bool skipValue(TextScanner* s) {
  std::string_view text;
  std::int64_t whole = 0;
  double number = 0;
  if (s->peek("\"")) return takeQuoted(s, &text);
  if (s->literal("0x")) return s->hex(1, 15, &whole);
  return s->number(&number);
}

}  // namespace

void Qm33Parser::reset() {
  LineRangeParser::reset();
  block_.clear();
}

LineRangeParser::Verdict Qm33Parser::parseLine(std::string_view line,
                                               std::vector<RangeReading>* out) {
  const std::size_t head = line.find(kHead);
  if (head != line.npos) {
    if (!block_.empty()) ++counters_.corrupt;  // the one before has no end
    block_.assign(line.substr(head));
  } else if (block_.empty()) {
    return line.find("mac_address=") != line.npos ? Verdict::corrupt : Verdict::other;
  } else {
    block_ += ' ';
    block_ += line;
  }
  if (block_.size() > kLongestBlock) {
    block_.clear();
    return Verdict::corrupt;
  }
  if (block_.find('}') == block_.npos) return Verdict::unfinished;
  const Verdict verdict = parseBlock(out);
  block_.clear();
  return verdict;
}

bool Qm33Parser::parseItem(TextScanner* s) {
  RangeReading reading;
  std::string_view status;
  std::int64_t centimetres = 0;
  bool has_distance = false;
  s->blanks();
  if (!s->literal("[mac_address=0x") || !s->hex(1, 15, &reading.responder) || !s->literal(',')) {
    return false;
  }
  s->blanks();
  if (!s->literal("status=") || !takeQuoted(s, &status)) return false;
  while (s->literal(',')) {
    s->blanks();
    const std::string_view name = takeName(s);
    if (name.empty() || !s->literal('=')) return false;
    if (name == "distance[cm]") {
      if (has_distance || !s->integer(&centimetres)) return false;
      has_distance = true;
    } else if (name == "RSSI[dBm]") {
      double rssi = 0;
      if (!s->number(&rssi)) return false;
      reading.rssi_dbm = rssi;
    } else if (!skipValue(s)) {
      return false;
    }
  }
  if (!s->literal(']')) return false;
  if (status != "SUCCESS") {
    ++failed_;
    return true;
  }
  reading.range_m = static_cast<double>(centimetres) / 100;
  found_.push_back(reading);
  return has_distance;
}

LineRangeParser::Verdict Qm33Parser::parseBlock(std::vector<RangeReading>* out) {
  TextScanner s(block_);
  std::int64_t handle = 0, sequence = 0, index = 0, count = 0;
  s.literal(kHead);
  s.blanks();
  if (!s.literal('{') || !field(&s, "session_handle", &handle) || !s.literal(',') ||
      !field(&s, "sequence_number", &sequence) || !s.literal(',') ||
      !field(&s, "block_index", &index) || !s.literal(',') ||
      !field(&s, "n_measurements", &count) || count > kMaxItems) {
    return Verdict::corrupt;
  }
  found_.clear();
  failed_ = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    if (!parseItem(&s)) return Verdict::corrupt;
    s.blanks();
    if (s.literal(';') != (i + 1 < count)) return Verdict::corrupt;
  }
  s.blanks();
  if (!s.literal('}')) return Verdict::corrupt;
  s.blanks();
  if (!s.atEnd()) return Verdict::corrupt;
  counters_.failed += failed_;
  for (const RangeReading& reading : found_) give(reading, out);
  return Verdict::message;
}

}  // namespace vir::uwb
