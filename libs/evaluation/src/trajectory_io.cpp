#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <istream>
#include <limits>
#include <ostream>

#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {
namespace {

constexpr std::size_t kMaxMessages = 20;
enum class Format { tum, euroc };

std::string clean(std::string line) {
  if (line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
  line.erase(std::min(line.find('#'), line.size()));
  const char* blanks = " \t\r\n";
  const std::size_t last = line.find_last_not_of(blanks);
  line.erase(last == std::string::npos ? 0 : last + 1);
  line.erase(0, std::min(line.find_first_not_of(blanks), line.size()));
  return line;
}

std::vector<std::string> split(const std::string& line, Format format) {
  std::vector<std::string> fields;
  std::size_t pos = 0;
  if (format == Format::euroc) {
    while (pos <= line.size()) {
      const std::size_t end = std::min(line.find(',', pos), line.size());
      fields.push_back(clean(line.substr(pos, end - pos)));
      pos = end + 1;
    }
    return fields;
  }
  while ((pos = line.find_first_not_of(" \t", pos)) != std::string::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", pos), line.size());
    fields.push_back(line.substr(pos, end - pos));
    pos = end;
  }
  return fields;
}

template <typename T>
bool parseNumber(const std::string& text, T* value) {
  const char* first = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const char* last = text.data() + text.size();
  const auto result = std::from_chars(first, last, *value);
  return result.ec == std::errc() && result.ptr == last;
}

/// Collects poses from lines and keeps the report.
class Reader {
 public:
  Reader(Format format, ReadReport* report) : format_(format), report_(report) {}

  void line(const std::string& cleaned, long number) {
    StampedPose pose;
    if (!parse(cleaned, number, &pose)) return;
    if (!poses_.empty() && pose.t < latest_) ++report_->out_of_order;
    latest_ = poses_.empty() ? pose.t : std::max(latest_, pose.t);
    poses_.push_back(pose);
    lines_.push_back(number);
  }

  Trajectory finish() {
    std::vector<std::size_t> order(poses_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return poses_[a].t < poses_[b].t; });
    Trajectory result;
    result.reserve(order.size());
    for (const std::size_t i : order) {
      if (!result.empty() && result.back().t == poses_[i].t) {
        skip(&report_->repeated, lines_[i], "the stamp was there already, the first pose is kept");
      } else {
        result.push_back(poses_[i]);
      }
    }
    report_->poses = static_cast<long>(result.size());
    return result;
  }

 private:
  bool skip(long* counter, long number, const std::string& why) {
    ++*counter;
    if (report_->messages.size() < kMaxMessages) {
      report_->messages.push_back("line " + std::to_string(number) + ": " + why);
    }
    return false;
  }

  bool parseStamp(const std::string& text, long number, TimeNs* t) {
    if (format_ == Format::euroc) {
      if (parseNumber(text, t)) return true;
      return skip(&report_->malformed, number, "'" + text + "' is not a stamp in integer ns");
    }
    if (parseSeconds(text, t)) return true;
    const bool looks_ns = text.find_first_of("0123456789") == 0 && text.size() >= 16;
    return skip(&report_->malformed, number,
                "'" + text + "' is not a stamp in seconds" +
                    (looks_ns ? " (nanoseconds? TUM files hold seconds)" : ""));
  }

  bool parse(const std::string& cleaned, long number, StampedPose* pose) {
    const std::vector<std::string> f = split(cleaned, format_);
    const bool count_ok = format_ == Format::tum ? f.size() == 8 : f.size() >= 8;
    if (!count_ok) {
      return skip(&report_->malformed, number,
                  "expected 8 numbers, found " + std::to_string(f.size()) + " fields");
    }
    if (!parseStamp(f[0], number, &pose->t)) return false;
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (!parseNumber(f[i + 1], &v[i])) {
        return skip(&report_->malformed, number, "'" + f[i + 1] + "' is not a number");
      }
      if (!std::isfinite(v[i])) {
        return skip(&report_->not_finite, number, "'" + f[i + 1] + "' is not finite");
      }
    }
    pose->T_W_B.p = Vec3(v[0], v[1], v[2]);
    const Quat q = format_ == Format::tum ? Quat(v[6], v[3], v[4], v[5])   // x y z w in the file
                                          : Quat(v[3], v[4], v[5], v[6]);  // w x y z in the file
    const double n = q.norm();
    if (!(n > 1e-6) || !std::isfinite(n)) {
      return skip(&report_->zero_quaternions, number, "the quaternion has no usable length");
    }
    if (std::abs(n - 1.0) > 1e-3) ++report_->quaternions_normalised;
    pose->T_W_B.q = q.normalized();
    return true;
  }

  Format format_;
  ReadReport* report_;
  Trajectory poses_;
  std::vector<long> lines_;
  TimeNs latest_ = 0;
};

Trajectory read(std::istream& in, ReadReport* report, const Format* forced) {
  ReadReport local;
  Format format = forced ? *forced : Format::tum;
  std::vector<Reader> reader;  // made when the format is known
  std::string line;
  for (long number = 1; std::getline(in, line); ++number) {
    line = clean(line);
    if (line.empty()) continue;
    if (reader.empty()) {
      if (!forced && line.find(',') != std::string::npos) format = Format::euroc;
      reader.emplace_back(format, &local);
    }
    reader.front().line(line, number);
  }
  Trajectory result = reader.empty() ? Trajectory() : reader.front().finish();
  if (report) *report = local;
  return result;
}

}  // namespace

bool parseSeconds(const std::string& text, TimeNs* t) {
  std::size_t i = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) ++i;
  std::string digits;
  int exponent = 0;  // value = 0.digits * 10^exponent
  bool point = false, any = false;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      any = true;
      if (c == '0' && digits.empty()) {
        if (point) --exponent;  // a zero right after the point
        continue;
      }
      digits += c;
      if (!point) ++exponent;
    } else {
      break;
    }
  }
  if (!any) return false;
  if (i < text.size()) {
    int e = 0;
    if ((text[i] != 'e' && text[i] != 'E') || !parseNumber(text.substr(i + 1), &e)) return false;
    if (std::abs(e) > 400) return false;
    exponent += e;
  }
  *t = 0;
  const int keep = exponent + 9;  // digits in front of the nanosecond's point
  if (digits.empty() || keep < 0) return true;
  if (keep > 19) return false;
  digits.resize(std::max<std::size_t>(digits.size(), keep + 1), '0');
  std::uint64_t ns = 0;
  constexpr std::uint64_t kMax = std::numeric_limits<TimeNs>::max();
  for (int k = 0; k < keep; ++k) {
    const std::uint64_t d = digits[k] - '0';
    if (ns > (kMax - d) / 10) return false;
    ns = ns * 10 + d;
  }
  if (digits[keep] >= '5' && ns < kMax) ++ns;
  *t = negative ? -static_cast<TimeNs>(ns) : static_cast<TimeNs>(ns);
  return true;
}

std::string formatSeconds(TimeNs t) {
  // Unsigned, so that the smallest value has an absolute value too.
  const std::uint64_t u = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  char text[48];
  std::snprintf(text, sizeof text, "%s%llu.%09llu", t < 0 ? "-" : "",
                static_cast<unsigned long long>(u / 1000000000u),
                static_cast<unsigned long long>(u % 1000000000u));
  return text;
}

Trajectory readTum(std::istream& in, ReadReport* report) {
  const Format format = Format::tum;
  return read(in, report, &format);
}

Trajectory readEurocGroundTruth(std::istream& in, ReadReport* report) {
  const Format format = Format::euroc;
  return read(in, report, &format);
}

Trajectory readTrajectory(std::istream& in, ReadReport* report) {
  return read(in, report, nullptr);
}

std::vector<TimeNs> readStamps(std::istream& in) {
  std::vector<TimeNs> stamps;
  std::string line;
  while (std::getline(in, line)) {
    TimeNs t = 0;
    const std::string first = split(clean(line), Format::euroc).front();
    if (parseNumber(first, &t)) stamps.push_back(t);
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

std::string tumLine(const StampedPose& pose) {
  const Vec3& p = pose.T_W_B.p;
  const Quat& q = pose.T_W_B.q;
  char text[512];
  std::snprintf(text, sizeof text, " %.9f %.9f %.9f %.9f %.9f %.9f %.9f", p.x(), p.y(), p.z(),
                q.x(), q.y(), q.z(), q.w());
  return formatSeconds(pose.t) + text;
}

void writeTum(std::ostream& out, const Trajectory& trajectory) {
  for (const StampedPose& pose : trajectory) out << tumLine(pose) << '\n';
}

}  // namespace vir::evaluation
