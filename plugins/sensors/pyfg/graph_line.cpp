#include "graph_line.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "text_fields.h"
#include "vir/core/angles.h"
#include "vir/core/parse_number.h"
#include "vir/evaluation/trajectory.h"

namespace vir::pyfg {
namespace {

using Fields = std::vector<std::string_view>;

constexpr double kMaxPosition = 1e7;       // [m]: more is no place on Earth
constexpr double kMaxRange = 1e6;          // [m]
constexpr double kMaxVariance = 1e9;       // of a motion [m^2], [rad^2]
constexpr double kMaxNormError = 1e-2;     // of a quaternion
constexpr std::size_t kShownInFault = 40;  // characters of a bad field

std::string shown(std::string_view field) {
  return "`" + std::string(field.substr(0, kShownInFault)) + "`";
}

bool fail(LineFault* fault, const char* kind, const std::string& text) {
  *fault = {kind, text};
  return false;
}

bool parseName(std::string_view field, Name* name) {
  if (field.size() < 2 || field.size() > 10) return false;
  const char c = field.front();
  if (!((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))) return false;
  name->letter = c;
  return parseNumber(field.substr(1), &name->number) && name->number >= 0;
}

/// Takes the fields of one line from left to right; after a failure it takes no more.
class FieldReader {
 public:
  FieldReader(const Fields& fields, LineFault* fault) : fields_(fields), fault_(fault) {}

  bool count(std::size_t wanted) {
    if (fields_.size() == wanted) return true;
    return fail(fault_, "line_malformed",
                std::string(fields_[0]) + " has " + std::to_string(fields_.size()) + " fields; " +
                    std::to_string(wanted) + " are needed");
  }

  bool stamp(TimeNs* t) {
    const std::string_view field = fields_[at_++];
    const bool is_time = evaluation::parseSeconds(std::string(field), t);
    if (is_time && *t >= 0) return true;
    if (is_time) {
      return fail(fault_, "line_malformed",
                  shown(field) + " is a time before 0; add the same to all stamps");
    }
    return fail(fault_, "line_malformed", shown(field) + " is not a time in seconds");
  }

  bool name(Name* n) {
    const std::string_view field = fields_[at_++];
    if (parseName(field, n)) return true;
    return fail(fault_, "line_malformed", shown(field) + " is not a letter and a number");
  }

  bool numbers(double* v, int n) {
    for (int i = 0; i < n; ++i) {
      const std::string_view field = fields_[at_++];
      if (!parseNumber(field, &v[i])) {
        return fail(fault_, "line_malformed", shown(field) + " is not a number");
      }
      if (!std::isfinite(v[i])) {
        return fail(fault_, "line_not_finite", shown(field) + " is not finite");
      }
    }
    return true;
  }

  bool position(Vec3* p, int dimension) {
    if (!numbers(p->data(), dimension)) return false;
    if (p->cwiseAbs().maxCoeff() <= kMaxPosition) return true;
    return fail(fault_, "line_implausible", "a position beyond 10000 km");
  }

  bool poseSe3(Pose* pose) {
    double q[4];
    if (!position(&pose->p, 3) || !numbers(q, 4)) return false;
    const Quat raw(q[3], q[0], q[1], q[2]);
    const double norm = raw.norm();
    if (!(std::abs(norm - 1) <= kMaxNormError)) {
      return fail(fault_, "line_bad_quaternion",
                  "a quaternion of length " + std::to_string(norm) + " instead of 1");
    }
    pose->q = raw.normalized();
    return true;
  }

  bool poseSe2(Pose* pose) {
    double theta = 0;
    if (!position(&pose->p, 2) || !numbers(&theta, 1)) return false;
    pose->q = expQuat(Vec3(0, 0, std::remainder(theta, 2 * kPi)));
    return true;
  }

  /// Upper triangle, row by row; `index` says which rows of the 6x6 they are.
  bool covariance(const std::vector<int>& index, MotionEdge* edge) {
    Mat6& c = edge->covariance;
    for (std::size_t i = 0; i < index.size(); ++i) {
      for (std::size_t j = i; j < index.size(); ++j) {
        double v = 0;
        if (!numbers(&v, 1)) return false;
        c(index[i], index[j]) = c(index[j], index[i]) = v;
      }
    }
    const Eigen::SelfAdjointEigenSolver<Mat6> solver(c, Eigen::EigenvaluesOnly);
    const double least = solver.eigenvalues()[0], most = solver.eigenvalues()[5];
    edge->covariance_usable = most <= kMaxVariance && least >= -1e-9 * std::abs(most);
    if (!edge->covariance_usable) c.setZero();
    return true;
  }

 private:
  const Fields& fields_;
  LineFault* fault_;
  std::size_t at_ = 1;
};

bool parseVertex(const Fields& f, bool planar, Vertex* v, LineFault* fault) {
  FieldReader r(f, fault);
  if (!r.count(planar ? 6 : 10) || !r.stamp(&v->t) || !r.name(&v->name)) return false;
  return planar ? r.poseSe2(&v->T_W_B) : r.poseSe3(&v->T_W_B);
}

bool parseMotion(const Fields& f, bool planar, MotionEdge* e, LineFault* fault) {
  FieldReader r(f, fault);
  e->planar = planar;
  if (!r.count(planar ? 13 : 32) || !r.stamp(&e->t) || !r.name(&e->from) || !r.name(&e->to)) {
    return false;
  }
  if (planar) return r.poseSe2(&e->T_from_to) && r.covariance({0, 1, 5}, e);
  return r.poseSe3(&e->T_from_to) && r.covariance({0, 1, 2, 3, 4, 5}, e);
}

bool parseRange(const Fields& f, RangeEdge* e, LineFault* fault) {
  FieldReader r(f, fault);
  double v[2];
  if (!r.count(6) || !r.stamp(&e->t) || !r.name(&e->a) || !r.name(&e->b) || !r.numbers(v, 2)) {
    return false;
  }
  if (v[0] < 0 || v[0] > kMaxRange) {
    return fail(fault, "line_implausible", "a range of " + std::string(f[4]) + " m");
  }
  if (v[1] <= 0) {
    return fail(fault, "line_implausible", "a variance of " + std::string(f[5]) + " m^2");
  }
  e->range_m = v[0];
  e->variance = v[1];
  return true;
}

/// With or without a stamp, which means nothing for a thing that stands still.
bool parseLandmark(const Fields& f, bool planar, Landmark* l, LineFault* fault) {
  FieldReader r(f, fault);
  const std::size_t least = planar ? 4 : 5;
  l->planar = planar;
  TimeNs ignored = 0;
  if (f.size() == least + 1) {
    if (!r.stamp(&ignored)) return false;
  } else if (!r.count(least)) {
    return false;
  }
  return r.name(&l->name) && r.position(&l->p_W, planar ? 2 : 3);
}

/// Parses into `item` and passes it on.
template <typename Item, typename Parser>
bool into(Line* line, Parser parse) {
  Item item;
  if (!parse(&item)) return false;
  *line = item;
  return true;
}

}  // namespace

std::string toString(const Name& name) { return name.letter + std::to_string(name.number); }

bool parseLine(std::string_view text, Line* line, LineFault* fault) {
  Fields f;
  splitFields(text, &f);
  const std::string_view keyword = f.empty() ? std::string_view() : f[0];
  if (keyword == "EDGE_RANGE") {
    return into<RangeEdge>(line, [&](RangeEdge* e) { return parseRange(f, e, fault); });
  }
  for (const bool planar : {false, true}) {
    if (keyword == (planar ? "VERTEX_SE2" : "VERTEX_SE3:QUAT")) {
      return into<Vertex>(line, [&](Vertex* v) { return parseVertex(f, planar, v, fault); });
    }
    if (keyword == (planar ? "EDGE_SE2" : "EDGE_SE3:QUAT")) {
      return into<MotionEdge>(line,
                              [&](MotionEdge* e) { return parseMotion(f, planar, e, fault); });
    }
    if (keyword == (planar ? "VERTEX_XY" : "VERTEX_XYZ")) {
      return into<Landmark>(line, [&](Landmark* l) { return parseLandmark(f, planar, l, fault); });
    }
  }
  return fail(fault, "line_unknown_keyword",
              shown(keyword) + " is none of the keywords known here");
}

}  // namespace vir::pyfg
