#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <istream>
#include <map>
#include <optional>
#include <ostream>
#include <sstream>
#include <utility>

#include "vir/core/parse_number.h"
#include "vir/core/text_file.h"
#include "vir/evaluation/trajectory.h"
#include "vir/tables/layout.h"
#include "vir/tables/unknown_units.h"

namespace vir::evaluation {
namespace {

/// Lines looked at before the layout is decided.
constexpr std::size_t kLook = 256;

/// How the lines of a file are read.
struct Habit {
  tables::RowFormat format;
  tables::PoseColumns columns;
  tables::StampUnit unit = tables::StampUnit::seconds;
  int nanoseconds = -1;     ///< column of what belongs to whole seconds
  std::size_t exactly = 0;  ///< fields that a line must have; 0: at least those that are needed
  bool header = false;      ///< a first line without numbers is one
  bool no_poses = false;    ///< as a note says
};

Habit tumHabit() {
  Habit h;
  for (int i = 0; i < 4; ++i) h.columns.q[i] = 4 + i;
  h.exactly = 8;
  return h;
}

/// By the first lines of a file.
Habit habitOf(const std::string& text, ReadReport* report) {
  const tables::Layout layout = tables::layoutOfText(text);
  Habit h;
  h.format = layout;
  h.columns = tables::poseColumns(layout);
  h.header = true;
  const auto expected =
      layout.separator == ' ' ? tables::StampUnit::seconds : tables::StampUnit::nanoseconds;
  const tables::UnitGuess guess = tables::stampUnit(layout, h.columns.stamp, 0.02);
  h.unit = guess.sure ? guess.unit : expected;
  h.nanoseconds = tables::nanosecondColumn(layout, h.columns.stamp);
  const std::string order = tables::assumedOrder(layout, h.columns);
  if (!order.empty()) report->notes.push_back(order);
  if (h.columns.unit_m != 1) report->notes.push_back("the header's unit of length is taken");
  const std::string why_not = tables::whyNoPoses(layout);
  h.no_poses = !why_not.empty();
  if (h.no_poses) {
    report->notes.push_back(why_not);
    return h;
  }
  const int* p = h.columns.p;
  const std::string unknown =
      h.columns.named ? tables::unknownUnits(layout, {p[0], p[1], p[2]}) : std::string();
  if (!unknown.empty()) report->notes.push_back(unknown);
  report->positions_only = !layout.rows.empty() && !h.columns.hasAttitude();
  const std::string unknown_time = tables::unknownStampUnit(layout, h.columns.stamp, h.unit);
  if (!unknown_time.empty()) {
    report->notes.push_back(unknown_time);
  } else if (h.unit != expected) {
    report->notes.push_back(std::string("the stamps are in ") + tables::name(h.unit));
  }
  const std::string stamps = tables::stampRemark(layout, h.columns.stamp);
  if (!stamps.empty()) report->notes.push_back(stamps);
  if (report->positions_only) report->notes.push_back("holds positions only, no attitudes");
  if (!h.columns.remark.empty()) report->notes.push_back(h.columns.remark);
  return h;
}

std::string clean(std::string line) {
  if (line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
  line.erase(std::min(line.find('#'), line.size()));
  const char* blanks = " \t\r\n";
  const std::size_t last = line.find_last_not_of(blanks);
  line.erase(last == std::string::npos ? 0 : last + 1);
  line.erase(0, std::min(line.find_first_not_of(blanks), line.size()));
  return line;
}

std::string quoted(std::string_view field) { return "'" + std::string(field.substr(0, 60)) + "'"; }

/// Collects poses from lines and keeps the report.
class Reader {
 public:
  Reader(const Habit& habit, ReadReport* report)
      : habit_(habit), splitter_(habit.format), report_(report) {}

  void line(const std::string& cleaned, long number) {
    if (habit_.header && poses_.empty() && !seen_ && isHeader(cleaned)) {
      seen_ = true;
      return;
    }
    seen_ = true;
    StampedPose pose;
    if (!parse(cleaned, number, &pose)) return;
    if (!poses_.empty() && pose.t < latest_) ++report_->out_of_order;
    latest_ = poses_.empty() ? pose.t : std::max(latest_, pose.t);
    poses_.push_back(pose);
    lines_.push_back(number);
  }

  /// The poses so far are of another frame; without a transform the line that says so is damaged.
  void changeFrame(const std::optional<Pose>& T_new_old, long number) {
    if (T_new_old) {
      changes_.emplace_back(poses_.size(), *T_new_old);
    } else {
      skip(&report_->malformed, "frame", number,
           "says that the poses above are of another frame, but not where that lies (seven numbers "
           "x y z qx qy qz qw): they are taken as they are");
    }
  }

  Trajectory finish() {
    toLastFrame();
    std::vector<std::size_t> order(poses_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return poses_[a].t < poses_[b].t; });
    Trajectory result;
    result.reserve(order.size());
    for (const std::size_t i : order) {
      if (!result.empty() && result.back().t == poses_[i].t) {
        skip(&report_->repeated, "repeated", lines_[i],
             "the stamp was there already, the first pose is kept");
      } else {
        result.push_back(poses_[i]);
      }
    }
    report_->poses = static_cast<long>(result.size());
    for (const auto& [kind, fault] : faults_) {
      if (fault.count < 2) continue;
      report_->messages[fault.message] +=
          " (and " + std::to_string(fault.count - 1) + " more like this)";
    }
    return result;
  }

 private:
  void toLastFrame() {
    Pose T_last;
    auto change = changes_.rbegin();
    for (std::size_t i = poses_.size(); i-- > 0 && !changes_.empty();) {
      for (; change != changes_.rend() && i < change->first; ++change) {
        T_last = T_last * change->second;
        T_last.q.normalize();
      }
      poses_[i].T_W_B = T_last * poses_[i].T_W_B;
    }
  }

  struct Fault {
    std::size_t message = 0;
    long count = 0;
  };

  static bool isHeader(const std::string& line) {
    const char c = line.front();
    return c != '-' && c != '+' && c != '.' && (c < '0' || c > '9');
  }

  /// Counts; the first of each kind is described.
  bool skip(long* counter, const std::string& kind, long number, const std::string& why) {
    ++*counter;
    Fault& fault = faults_[kind];
    if (fault.count++ == 0) {
      fault.message = report_->messages.size();
      report_->messages.push_back("line " + std::to_string(number) + ": " + why);
    }
    return false;
  }

  bool parseStamp(std::string_view text, long number, TimeNs* t) {
    if (tables::parseStamp(text, habit_.unit, t)) return true;
    const bool seconds = habit_.unit == tables::StampUnit::seconds;
    const bool looks_ns = seconds && text.find_first_of("0123456789") == 0 && text.size() >= 16;
    return skip(&report_->malformed, looks_ns ? "stamp in ns" : "stamp", number,
                quoted(text) + " is not a stamp in " +
                    (seconds ? "seconds" : tables::name(habit_.unit)) +
                    (looks_ns ? " (nanoseconds? TUM files hold seconds)" : ""));
  }

  bool addNanoseconds(long number, TimeNs* t) {
    const auto text = fields_[static_cast<std::size_t>(habit_.nanoseconds)];
    if (tables::addNanoseconds(text, t)) return true;
    return skip(&report_->malformed, "nanoseconds", number,
                quoted(text) + " is no number of nanoseconds of a second");
  }

  bool value(int column, long number, double* v) {
    const std::string_view field = fields_[static_cast<std::size_t>(column)];
    if (!parseNumber(field, v)) {
      const bool comma = field.find(',') != std::string_view::npos;
      return skip(&report_->malformed, "number", number,
                  quoted(field) + " is not a number" +
                      (comma ? " (a decimal comma? numbers need a point)" : ""));
    }
    if (std::isfinite(*v)) return true;
    return skip(&report_->not_finite, "finite", number, quoted(field) + " is not finite");
  }

  /// x y z w, as it was without any.
  bool attitude(long number, double* xyzw) {
    const tables::PoseColumns& c = habit_.columns;
    if (c.hasAngles()) {
      double angles[3];
      for (int i = 0; i < 3; ++i) {
        if (!value(c.angles[i], number, &angles[i])) return false;
        angles[i] *= c.angle_unit;
      }
      tables::quaternionOf(angles, xyzw);
      return true;
    }
    for (int i = 0; i < 4 && c.hasAttitude(); ++i) {
      if (!value(c.q[i], number, &xyzw[i])) return false;
    }
    return true;
  }

  bool parse(const std::string& cleaned, long number, StampedPose* pose) {
    splitter_.split(cleaned, &fields_);
    const tables::PoseColumns& c = habit_.columns;
    const auto needed = static_cast<std::size_t>(std::max(c.last(), habit_.nanoseconds) + 1);
    const bool enough =
        habit_.exactly > 0 ? fields_.size() == habit_.exactly : fields_.size() >= needed;
    if (!enough) {
      return skip(&report_->malformed, "fields", number,
                  "expected " + std::to_string(needed) + " numbers, found " +
                      std::to_string(fields_.size()) + " fields");
    }
    const auto stamp = fields_[static_cast<std::size_t>(c.stamp)];
    if (!parseStamp(stamp, number, &pose->t)) return false;
    if (habit_.nanoseconds >= 0 && !addNanoseconds(number, &pose->t)) return false;
    std::array<double, 7> v{0, 0, 0, 0, 0, 0, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!value(c.p[i], number, &v[i])) return false;
    }
    if (!attitude(number, &v[3])) return false;
    tables::eastNorthUp(c, v.data(), &v[3]);
    pose->T_W_B.p = c.unit_m * Vec3(v[0], v[1], v[2]);
    const Quat q(v[6], v[3], v[4], v[5]);
    const double n = q.norm();
    if (!(n > 1e-6) || !std::isfinite(n)) {
      return skip(&report_->zero_quaternions, "length", number,
                  "the quaternion has no usable length");
    }
    if (std::abs(n - 1.0) > 1e-3) ++report_->quaternions_normalised;
    pose->T_W_B.q = q.normalized();
    return true;
  }

  Habit habit_;
  tables::RowSplitter splitter_;
  ReadReport* report_;
  Trajectory poses_;
  std::vector<long> lines_;
  std::vector<std::pair<std::size_t, Pose>> changes_;  ///< of the frame, after so many poses
  std::vector<std::string_view> fields_;
  std::map<std::string, Fault> faults_;
  TimeNs latest_ = 0;
  bool seen_ = false;
};

constexpr const char* kFrameChange = "# the poses above are of another frame, which lies here at";
/// What is left of it where it is damaged.
constexpr const char* kFrameChangeBegin = "# the poses above are of another frame";

constexpr double kFarthest_m = 1e9;

/// Of a frameChangeLine(); nothing where it is damaged.
std::optional<Pose> frameChangeOf(const std::string& line) {
  if (line.rfind(kFrameChange, 0) != 0) return std::nullopt;
  std::istringstream numbers(line.substr(std::strlen(kFrameChange)));
  double v[7];
  for (double& x : v) {
    std::string word;
    if (!(numbers >> word) || !parseNumber(word, &x) || !(std::abs(x) < kFarthest_m))
      return std::nullopt;
  }
  const Quat q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1) < 1e-3)) return std::nullopt;
  return Pose(q.normalized(), Vec3(v[0], v[1], v[2]));
}

/// `forced`: as the caller knows; else by the first lines.
Trajectory read(std::istream& in, ReadReport* report, const Habit* forced) {
  ReadReport local;
  std::vector<std::string> first;
  std::string line;
  while (first.size() < kLook && readLine(in, &line)) first.push_back(line);
  std::string text;
  for (const std::string& l : first) text += l + '\n';
  const Habit habit = forced != nullptr ? *forced : habitOf(text, &local);
  if (habit.no_poses) {
    if (report != nullptr) *report = local;
    return {};
  }
  Reader reader(habit, &local);
  long number = 0;
  const auto take = [&](const std::string& raw) {
    ++number;
    const std::string cleaned = clean(raw);
    if (!cleaned.empty()) {
      reader.line(cleaned, number);
    } else if (raw.rfind(kFrameChangeBegin, 0) == 0) {
      reader.changeFrame(frameChangeOf(raw), number);
    }
  };
  for (const std::string& l : first) take(l);
  while (readLine(in, &line)) take(line);
  Trajectory result = reader.finish();
  if (report != nullptr) *report = local;
  return result;
}

/// " x y z qx qy qz qw"
std::string sevenOf(const Pose& T) {
  char text[512];
  std::snprintf(text, sizeof text, " %.9f %.9f %.9f %.9f %.9f %.9f %.9f", T.p.x(), T.p.y(), T.p.z(),
                T.q.x(), T.q.y(), T.q.z(), T.q.w());
  return text;
}

}  // namespace

bool parseSeconds(const std::string& text, TimeNs* t) {
  return tables::parseStamp(text, tables::StampUnit::seconds, t);
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
  const Habit habit = tumHabit();
  return read(in, report, &habit);
}

Trajectory readTrajectory(std::istream& in, ReadReport* report) {
  return read(in, report, nullptr);
}

std::vector<TimeNs> readStamps(std::istream& in) {
  std::vector<TimeNs> stamps;
  std::vector<std::string_view> fields;
  std::string line;
  while (readLine(in, &line)) {
    TimeNs t = 0;
    const std::string cleaned = clean(line);
    tables::splitLine(cleaned, ',', &fields);
    if (parseNumber(fields.front(), &t)) stamps.push_back(t);
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

std::string tumLine(const StampedPose& pose) { return formatSeconds(pose.t) + sevenOf(pose.T_W_B); }

std::string frameChangeLine(const Pose& T_new_old) { return kFrameChange + sevenOf(T_new_old); }

void writeTum(std::ostream& out, const Trajectory& trajectory) {
  for (const StampedPose& pose : trajectory) out << tumLine(pose) << '\n';
}

}  // namespace vir::evaluation
