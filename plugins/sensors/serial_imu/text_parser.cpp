#include "text_parser.h"

#include "text_scanner.h"

namespace vir::serial_imu {
namespace {

bool checksumIsRight(std::string_view line) {
  const std::size_t star = line.rfind('*');
  if (star == line.npos) return false;
  unsigned sum = 0;
  for (const char c : line.substr(0, star)) sum ^= static_cast<unsigned char>(c);
  TextScanner s(line.substr(star + 1));
  std::int64_t told = 0;
  return s.hex(2, 2, &told) && s.atEnd() && told == sum;
}

bool readLine(std::string_view line, ImuReading* r) {
  std::int64_t microseconds = 0;
  TextScanner s(line);
  if (!s.literal("IMU,") || !s.integer(&microseconds) || microseconds < 0 ||
      microseconds > UINT32_MAX) {
    return false;
  }
  r->device_time = microseconds * 1000;
  for (double& v : r->acc_m_s2) {
    if (!s.literal(',') || !s.number(&v)) return false;
  }
  for (double& v : r->gyro_rad_s) {
    if (!s.literal(',') || !s.number(&v)) return false;
  }
  return s.peek("*") && checksumIsRight(line);
}

}  // namespace

void TextParser::feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) {
  batch_.clear();
  lines_.feed(bytes, size, &batch_);
  for (const LineAssembler::Line& line : batch_) {
    ImuReading reading;
    if (!line.too_long && readLine(line.text, &reading)) {
      ++counters_.messages;
      give(reading, out);
    } else if (line.fragment || line.text.find("IMU") == std::string::npos) {
      ++counters_.other_text;
    } else {
      ++counters_.corrupt;
    }
  }
}

}  // namespace vir::serial_imu
