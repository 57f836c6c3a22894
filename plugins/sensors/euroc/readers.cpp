#include "readers.h"

#include <cctype>
#include <cmath>
#include <limits>

namespace vir::euroc {
namespace {

using Fields = std::vector<std::string_view>;

// Beyond these a number is a fault of the file or the device, not a measurement.
constexpr double kMaxRate = 1e3;          // rad/s
constexpr double kMaxAcceleration = 1e4;  // m/s^2
constexpr double kMaxPosition = 1e7;      // m
constexpr double kMaxRange = 1e5;         // m
constexpr double kMaxNormError = 0.02;    // of a quaternion

bool enough(const Fields& f, std::size_t n, RowFault* fault) {
  if (f.size() >= n) return true;
  *fault = {"malformed",
            "has " + std::to_string(f.size()) + " columns, needs " + std::to_string(n)};
  return false;
}

bool stamp(const Fields& f, TimeNs* t, RowFault* fault) {
  if (parseNs(f[0], t)) return true;
  *fault = {"malformed",
            "`" + std::string(f[0].substr(0, 40)) + "` is not a whole number of nanoseconds"};
  return false;
}

/// `n` finite numbers from field `from` on.
bool values(const Fields& f, std::size_t from, std::size_t n, double* out, RowFault* fault) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::string_view field = f[from + i];
    if (!parseNumber(field, &out[i])) {
      *fault = {"malformed", "column " + std::to_string(from + i + 1) + ": `" +
                                 std::string(field.substr(0, 40)) + "` is not a number"};
      return false;
    }
    if (!std::isfinite(out[i])) {
      *fault = {"not_finite", "column " + std::to_string(from + i + 1) + " is " +
                                  std::string(field.substr(0, 40))};
      return false;
    }
  }
  return true;
}

bool implausible(RowFault* fault, const std::string& text) {
  *fault = {"implausible", text};
  return false;
}

bool parseImu(const Fields& f, ImuRow* row, RowFault* fault) {
  double v[6];
  if (!enough(f, 7, fault) || !stamp(f, &row->t, fault) || !values(f, 1, 6, v, fault)) return false;
  row->gyro = Vec3(v[0], v[1], v[2]);
  row->acc = Vec3(v[3], v[4], v[5]);
  if (row->gyro.cwiseAbs().maxCoeff() > kMaxRate)
    return implausible(fault, "angular rate above 1000 rad/s");
  if (row->acc.cwiseAbs().maxCoeff() > kMaxAcceleration) {
    return implausible(fault, "acceleration above 10000 m/s^2");
  }
  return true;
}

bool parseImage(const Fields& f, ImageRow* row, RowFault* fault) {
  if (!enough(f, 2, fault) || !stamp(f, &row->t, fault)) return false;
  row->file = std::string(f[1]);
  if (row->file.empty() || row->file.find('\0') != std::string::npos) {
    *fault = {"malformed", "column 2 holds no file name"};
    return false;
  }
  return true;
}

bool anchorId(double v, int* id, RowFault* fault) {
  if (v != std::floor(v) || std::abs(v) > std::numeric_limits<std::int32_t>::max()) {
    *fault = {"malformed", "the anchor's id is not a whole number"};
    return false;
  }
  *id = static_cast<int>(v);
  return true;
}

bool parseRange(const Fields& f, RangeRow* row, RowFault* fault) {
  double v[2];
  if (!enough(f, 3, fault) || !stamp(f, &row->t, fault) || !values(f, 1, 2, v, fault) ||
      !anchorId(v[0], &row->anchor, fault)) {
    return false;
  }
  row->range_m = v[1];
  if (row->range_m < 0 || row->range_m > kMaxRange) {
    return implausible(fault, "a range of " + std::string(f[2]) + " m");
  }
  return true;
}

bool parseAnchor(const Fields& f, AnchorRow* row, RowFault* fault) {
  double v[4];
  if (!enough(f, 4, fault) || !values(f, 0, 4, v, fault) || !anchorId(v[0], &row->id, fault)) {
    return false;
  }
  row->p_W = Vec3(v[1], v[2], v[3]);
  return row->p_W.cwiseAbs().maxCoeff() <= kMaxPosition ||
         implausible(fault, "position beyond 10000 km");
}

bool makePose(const Vec3& p, Quat q, Pose* pose, RowFault* fault) {
  if (p.cwiseAbs().maxCoeff() > kMaxPosition) return implausible(fault, "position beyond 10000 km");
  if (std::abs(q.norm() - 1) > kMaxNormError)
    return implausible(fault, "the quaternion is not of unit length");
  *pose = Pose(q.normalized(), p);
  return true;
}

bool parsePoseCsv(const Fields& f, PoseRow* row, RowFault* fault) {
  double v[7];
  if (!enough(f, 8, fault) || !stamp(f, &row->t, fault) || !values(f, 1, 7, v, fault)) return false;
  return makePose(Vec3(v[0], v[1], v[2]), Quat(v[3], v[4], v[5], v[6]), &row->T_W_B, fault);
}

bool parsePoseTum(const Fields& f, PoseRow* row, RowFault* fault) {
  double v[7];
  if (!enough(f, 8, fault)) return false;
  if (!parseDecimalSeconds(f[0], &row->t)) {
    *fault = {"malformed",
              "`" + std::string(f[0].substr(0, 40)) + "` is not a time in decimal seconds"};
    return false;
  }
  if (!values(f, 1, 7, v, fault)) return false;
  return makePose(Vec3(v[0], v[1], v[2]), Quat(v[6], v[3], v[4], v[5]), &row->T_W_B, fault);
}

template <typename Row>
bool sameStamp(const Row&, const Row&) {
  return true;
}

template <typename Row, typename Parser>
std::unique_ptr<RowCursor<Row>> open(const std::string& path, const char* name, Parser parser,
                                     ProblemLog* log) {
  typename RowCursor<Row>::Spec spec{path, name, parser, sameStamp<Row>, false};
  return std::make_unique<RowCursor<Row>>(std::move(spec), log);
}

}  // namespace

std::unique_ptr<RowCursor<ImuRow>> openImu(const std::string& path, ProblemLog* log) {
  return open<ImuRow>(path, "imu", parseImu, log);
}

std::unique_ptr<RowCursor<ImageRow>> openImageList(const std::string& path, ProblemLog* log) {
  RowCursor<ImageRow>::Spec spec{path, "image", parseImage, sameStamp<ImageRow>, true};
  return std::make_unique<RowCursor<ImageRow>>(std::move(spec), log);
}

std::unique_ptr<RowCursor<RangeRow>> openRanges(const std::string& path, ProblemLog* log) {
  // Several anchors may answer at one time.
  const auto same = [](const RangeRow& a, const RangeRow& b) { return a.anchor == b.anchor; };
  RowCursor<RangeRow>::Spec spec{path, "range", parseRange, same, false};
  return std::make_unique<RowCursor<RangeRow>>(std::move(spec), log);
}

std::unique_ptr<RowCursor<PoseRow>> openGroundTruthCsv(const std::string& path, ProblemLog* log) {
  return open<PoseRow>(path, "ground_truth", parsePoseCsv, log);
}

std::unique_ptr<RowCursor<PoseRow>> openGroundTruthTum(const std::string& path, ProblemLog* log) {
  return open<PoseRow>(path, "ground_truth", parsePoseTum, log);
}

std::vector<AnchorRow> readAnchorTable(const std::string& path, ProblemLog* log) {
  std::vector<AnchorRow> anchors;
  LineReader lines(path);
  std::string line;
  Fields fields;
  for (bool first = true; lines.next(&line); first = false) {
    splitFields(line, &fields);
    AnchorRow row;
    RowFault fault;
    if (parseAnchor(fields, &row, &fault)) {
      anchors.push_back(row);
    } else if (!first || std::isalpha(static_cast<unsigned char>(line[0])) == 0) {
      log->add("anchor_" + fault.kind, lines.where(), fault.text);
    }
  }
  return anchors;
}

}  // namespace vir::euroc
