#include "readers.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "imu_units.h"
#include "row_values.h"
#include "vir/core/text_file.h"
#include "vir/core/time_bounds.h"
#include "vir/tables/unknown_units.h"

namespace vir::euroc {
namespace {

// Beyond these a number is a fault of the file or the device, not a measurement.
constexpr double kMaxRate = 1e3;          // rad/s
constexpr double kMaxAcceleration = 1e4;  // m/s^2
constexpr double kMaxPosition = 1e7;      // m
constexpr double kMaxNormError = 0.02;    // of a quaternion

// Time between rows of each kind, to tell the unit of stamps that are no dates.
constexpr double kImuStep = 0.005, kImageStep = 0.05, kPoseStep = 0.02;  // s

bool parseImu(const Fields& f, const tables::ImuColumns& c, const Stamps& stamps, ImuSample* row,
              RowFault* fault) {
  if (!enough(f, c.last(), fault) || !stamp(f, stamps, &row->t, fault) ||
      !vector(f, c.gyro, &row->gyro, fault) || !vector(f, c.acc, &row->acc, fault)) {
    return false;
  }
  if (c.gyro_unit != 1) row->gyro *= c.gyro_unit;
  if (c.acc_unit != 1) row->acc *= c.acc_unit;
  if (row->gyro.cwiseAbs().maxCoeff() > kMaxRate)
    return implausible(fault, "angular rate above 1000 rad/s");
  if (row->acc.cwiseAbs().maxCoeff() > kMaxAcceleration) {
    return implausible(fault, "acceleration above 10000 m/s^2");
  }
  return true;
}

bool parseImage(const Fields& f, const tables::ImageColumns& c, const Stamps& stamps, ImageRow* row,
                RowFault* fault) {
  if (!enough(f, std::max(c.stamp, c.file), fault) || !stamp(f, stamps, &row->t, fault)) {
    return false;
  }
  row->file = std::string(at(f, c.file < 0 ? c.stamp : c.file));
  if (row->file.empty() || row->file.find('\0') != std::string::npos) {
    *fault = {"malformed", "column " + std::to_string(c.file + 1) + " holds no file name"};
    return false;
  }
  return true;
}

bool parseAnchor(const Fields& f, tables::AnchorNames* names, AnchorRow* row, RowFault* fault) {
  const int columns[3] = {1, 2, 3};
  if (!enough(f, 3, fault) || !vector(f, columns, &row->p_W, fault) ||
      !anchorId(f[0], names, &row->id, fault)) {
    return false;
  }
  return row->p_W.cwiseAbs().maxCoeff() <= kMaxPosition ||
         implausible(fault, "position beyond 10000 km");
}

/// x y z w
bool attitude(const Fields& f, const tables::PoseColumns& c, double q[4], RowFault* fault) {
  if (c.hasAngles()) {
    Vec3 angles;
    if (!vector(f, c.angles, &angles, fault)) return false;
    angles *= c.angle_unit;
    tables::quaternionOf(angles.data(), q);
    return true;
  }
  for (int i = 0; i < 4; ++i) {
    if (!value(f, c.q[i], &q[i], fault)) return false;
  }
  if (q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0) return true;
  *fault = {"no_attitude", "the quaternion is 0 0 0 0, which is no attitude; not used"};
  return false;
}

bool parsePose(const Fields& f, const tables::PoseColumns& c, const Stamps& stamps, PoseRow* row,
               RowFault* fault) {
  Vec3 p;
  if (!enough(f, c.last(), fault) || !stamp(f, stamps, &row->t, fault) ||
      !vector(f, c.p, &p, fault)) {
    return false;
  }
  double q[4] = {0, 0, 0, 1};
  row->has_attitude = c.hasAttitude();
  if (row->has_attitude && !attitude(f, c, q, fault)) return false;
  tables::eastNorthUp(c, p.data(), q);
  p *= c.unit_m;
  if (p.cwiseAbs().maxCoeff() > kMaxPosition) return implausible(fault, "position beyond 10000 km");
  const Quat attitude(q[3], q[0], q[1], q[2]);
  if (std::abs(attitude.norm() - 1) > kMaxNormError)
    return implausible(fault, "the quaternion is not of unit length");
  row->T_W_B = Pose(attitude.normalized(), p);
  return true;
}

template <typename Row>
bool sameStamp(const Row&, const Row&) {
  return true;
}

template <typename Row, typename Parser>
std::unique_ptr<RowCursor<Row>> open(const std::string& path, const char* name,
                                     const tables::Layout& layout, Parser parser, ProblemLog* log) {
  typename RowCursor<Row>::Spec spec{path, name, parser, sameStamp<Row>, false, layout};
  return std::make_unique<RowCursor<Row>>(std::move(spec), log);
}

std::string listed(const int columns[3]) {
  std::string out;
  for (int i = 0; i < 3; ++i) out += " " + std::to_string(columns[i] + 1);
  return out;
}

/// `header`: what the header says it is in; `size`: of the vectors in the first rows.
double accUnit(const std::string& path, const Units& units, double header, double size,
               ProblemLog* log) {
  if (units.acc != 0) return units.acc;
  if (header != 1 || !units.guess_acc) return header;
  const bool g = size > 0.85 && size<1.15, small = size> 850 && size < 1150;
  if (!g && !small) return header;
  // Gravity is 980.7 in cm/s^2 and 1000 in mg.
  const bool cm = small && size < 990.3;
  const char* const unit = g ? "g" : cm ? "cm/s2" : "mg";
  char text[160];
  std::snprintf(text, sizeof text, ": |a| is %.4g at the beginning, so it is taken to be in %s%s",
                size, unit,
                g    ? ""
                : cm ? " (acc_unit=mg if not)"
                     : " (acc_unit=cm/s2 if not)");
  log->note(path + text);
  return accelerationUnit(unit);
}

/// A problem, not a note: the numbers are wrong by a factor.
void sayUnknownUnits(const std::string& path, const tables::Layout& layout, const int columns[3],
                     ProblemLog* log) {
  const std::string text = tables::unknownUnits(layout, {columns[0], columns[1], columns[2]});
  if (text.empty()) return;
  log->note(path + ": " + text);
  log->count("unknown_unit");
}

}  // namespace

std::unique_ptr<RowStream<ImuSample>> openImu(const std::string& path, const Units& units,
                                              ProblemLog* log) {
  const tables::Layout layout = tables::layoutOf(path);
  tables::ImuColumns c = tables::imuColumns(layout);
  Stamps stamps = stampsOf(path, layout, c.stamp, kImuStep, false, log);
  stamps.offset = units.imu_offset;
  if (c.named && (c.gyro[0] != 1 || c.acc[0] != 4)) {
    log->note(path + ": by its header the gyro is in columns" + listed(c.gyro) +
              ", the accelerometer in columns" + listed(c.acc));
  }
  if (!c.named && !c.turned) {
    tables::Taken taken{{c.stamp, "stamp"}};
    tables::addAxes(c.gyro, "gyro", &taken);
    tables::addAxes(c.acc, "accelerometer", &taken);
    sayByPosition(path, layout, taken, c.by_units, log);
  }
  if (c.turned) {
    log->note(path + ": the accelerometer is in columns" + listed(c.acc) + ", the gyro in columns" +
              listed(c.gyro) + ", by the size of the numbers: there is no header that says");
  }
  if (units.gyro <= 0) sayUnknownUnits(path, layout, c.gyro, log);
  if (units.acc == 0) sayUnknownUnits(path, layout, c.acc, log);
  if (units.gyro > 0) c.gyro_unit = units.gyro;
  c.acc_unit = accUnit(path, units, c.acc_unit, tables::medianNorm(layout, c.acc), log);
  sayUnit(path, "gyro", c.gyro_unit, "rad/s", log);
  sayUnit(path, "accelerometer", c.acc_unit, "m/s^2", log);
  const auto parse = [=](const Fields& f, ImuSample* row, RowFault* fault) {
    return parseImu(f, c, stamps, row, fault);
  };
  return open<ImuSample>(path, "imu", layout, parse, log);
}

std::unique_ptr<RowStream<VectorRow>> openVectors(const std::string& path, VectorKind kind,
                                                  const Units& units, ProblemLog* log) {
  const bool gyro = kind == VectorKind::gyro;
  const tables::Layout layout = tables::layoutOf(path);
  tables::VectorColumns c =
      gyro ? tables::gyroColumns(layout, true) : tables::accelerometerColumns(layout, true);
  Stamps stamps = stampsOf(path, layout, c.stamp, kImuStep, false, log);
  stamps.offset = units.imu_offset;
  if (!c.named) {
    tables::Taken taken{{c.stamp, "stamp"}};
    tables::addAxes(c.v, gyro ? "gyro" : "accelerometer", &taken);
    sayByPosition(path, layout, taken, false, log);
  }
  if (gyro && units.gyro > 0) c.unit = units.gyro;
  if (!gyro) c.unit = accUnit(path, units, c.unit, tables::medianNorm(layout, c.v), log);
  sayUnit(path, gyro ? "gyro" : "accelerometer", c.unit, gyro ? "rad/s" : "m/s^2", log);
  const auto parse = [=](const Fields& f, VectorRow* row, RowFault* fault) {
    if (!enough(f, c.last(), fault) || !stamp(f, stamps, &row->t, fault) ||
        !vector(f, c.v, &row->v, fault)) {
      return false;
    }
    row->v *= c.unit;
    return row->v.cwiseAbs().maxCoeff() <= kMaxAcceleration ||
           implausible(fault, "a value above 10000");
  };
  return open<VectorRow>(path, gyro ? "gyro" : "accelerometer", layout, parse, log);
}

std::unique_ptr<RowStream<ImageRow>> openImageList(const std::string& path, ProblemLog* log) {
  const tables::Layout layout = tables::layoutOf(path);
  const tables::ImageColumns c = tables::imageColumns(layout);
  const Stamps stamps = stampsOf(path, layout, c.stamp, kImageStep, false, log);
  const auto parse = [=](const Fields& f, ImageRow* row, RowFault* fault) {
    return parseImage(f, c, stamps, row, fault);
  };
  RowCursor<ImageRow>::Spec spec{path, "image", parse, sameStamp<ImageRow>, true, layout};
  return std::make_unique<RowCursor<ImageRow>>(std::move(spec), log);
}

std::unique_ptr<RowStream<PoseRow>> openGroundTruth(const std::string& path, ProblemLog* log) {
  const tables::Layout layout = tables::layoutOf(path);
  const tables::PoseColumns c = tables::poseColumns(layout);
  const Stamps stamps = stampsOf(path, layout, c.stamp, kPoseStep, layout.separator == ' ', log);
  const std::string why_not = tables::whyNoPoses(layout);
  const std::string no_text = whyNoText(path);
  if (!no_text.empty()) log->note(path + " " + no_text);
  const std::string order = tables::assumedOrder(layout, c);
  if (!c.hasAttitude() && why_not.empty()) log->note(path + ": holds positions only, no attitude");
  if (!c.remark.empty() && why_not.empty()) log->note(path + ": " + c.remark);
  if (!order.empty()) log->note(path + ": " + order);
  if (!why_not.empty()) log->note(path + ": " + why_not);
  if (c.named) {
    sayUnknownUnits(path, layout, c.p, log);
  } else if (why_not.empty()) {
    tables::Taken taken{{c.stamp, "stamp"}};
    tables::addAxes(c.p, "position", &taken);
    sayByPosition(path, layout, taken, false, log);
  }
  sayUnit(path, "positions", c.unit_m, "m", log);
  const auto parse = [=](const Fields& f, PoseRow* row, RowFault* fault) {
    if (!why_not.empty()) {
      *fault = {"no_pose", ""};
      return false;
    }
    return parsePose(f, c, stamps, row, fault);
  };
  return open<PoseRow>(path, "ground_truth", layout, parse, log);
}

std::vector<AnchorRow> readAnchorTable(const std::string& path, tables::AnchorNames* names,
                                       ProblemLog* log) {
  std::vector<AnchorRow> anchors;
  const tables::Layout layout = tables::layoutOf(path);
  tables::RowSplitter splitter(layout);
  LineReader lines(path);
  std::string line;
  Fields fields;
  for (bool first = true; lines.next(&line); first = false) {
    splitter.split(line, &fields);
    AnchorRow row;
    RowFault fault;
    if (parseAnchor(fields, names, &row, &fault)) {
      anchors.push_back(row);
    } else if (!first || std::isalpha(static_cast<unsigned char>(line[0])) == 0) {
      log->add("anchor_" + fault.kind, lines.where(), fault.text);
    }
  }
  return anchors;
}

}  // namespace vir::euroc
