#include "output/evaluation_report.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "output/picture_file.h"
#include "vir/evaluation/figure.h"

namespace vir::app {
namespace {

using Row = std::vector<std::string>;
using nlohmann::json;

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string trimmed(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// Columns as wide as their widest cell: the first to the left, the others to the right.
std::string layout(const std::vector<Row>& rows) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) width[k] = std::max(width[k], row[k].size());
  }
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::string line;
    for (std::size_t k = 0; k < rows[i].size(); ++k) {
      const std::string blanks(width[k] - rows[i][k].size(), ' ');
      line += k == 0 ? rows[i][k] + blanks : "  " + blanks + rows[i][k];
    }
    text += line + "\n";
    if (i == 0) text += std::string(line.size(), '-') + "\n";
  }
  return text;
}

class Table {
 public:
  explicit Table(const std::vector<Evaluated>& estimates) {
    Row head{"Metric"};
    for (const Evaluated& e : estimates) {
      if (e.result) shown_.push_back(&e);
    }
    for (const Evaluated* e : shown_) head.push_back(e->name);
    rows_.push_back(head);
  }

  void add(const std::string& metric,
           const std::function<std::string(const evaluation::EvaluationResult&)>& cell) {
    Row row{metric};
    for (const Evaluated* e : shown_) row.push_back(cell(*e->result));
    rows_.push_back(row);
  }

  void addImages() {
    Row covered{"images with a pose"}, first{"first pose after first image [s]"};
    for (const Evaluated* e : shown_) {
      if (!e->images) return;
      const ImageCoverage& i = *e->images;
      covered.push_back(std::to_string(i.covered) + " of " + std::to_string(i.images));
      first.push_back(number(i.first_pose_after_s, 2));
    }
    rows_.push_back(covered);
    rows_.push_back(first);
  }

  bool empty() const { return shown_.empty(); }
  const evaluation::EvaluationResult& first() const { return *shown_.front()->result; }
  std::string text() const { return layout(rows_); }

 private:
  std::vector<const Evaluated*> shown_;
  std::vector<Row> rows_;
};

void addRelative(Table* table) {
  for (std::size_t i = 0; i < table->first().rpe_distance.size(); ++i) {
    const std::string over = "RPE over " + trimmed(table->first().rpe_distance[i].length) + " m ";
    const auto cell = [i](evaluation::Statistics evaluation::RelativeError::*s, int decimals) {
      return [=](const evaluation::EvaluationResult& r) {
        const evaluation::Statistics& v = r.rpe_distance[i].*s;
        return v.count > 0 ? number(v.rmse, decimals) : std::string("-");
      };
    };
    table->add(over + "translation rmse [m]", cell(&evaluation::RelativeError::translation_m, 4));
    table->add(over + "translation rmse [%]", cell(&evaluation::RelativeError::translation_pct, 2));
    table->add(over + "rotation rmse [deg]", cell(&evaluation::RelativeError::rotation_deg, 3));
    table->add(over + "yaw rmse [deg]", cell(&evaluation::RelativeError::yaw_deg, 3));
  }
  const std::string over = "RPE over " + trimmed(table->first().rpe_time.length) + " s ";
  const auto cell = [](evaluation::Statistics evaluation::RelativeError::*s, int decimals) {
    return [=](const evaluation::EvaluationResult& r) {
      const evaluation::Statistics& v = r.rpe_time.*s;
      return v.count > 0 ? number(v.rmse, decimals) : std::string("-");
    };
  };
  table->add(over + "translation rmse [m]", cell(&evaluation::RelativeError::translation_m, 4));
  table->add(over + "rotation rmse [deg]", cell(&evaluation::RelativeError::rotation_deg, 3));
}

json toJson(const evaluation::Statistics& s) {
  if (s.count == 0) return {{"count", 0}};
  return {{"count", s.count},   {"rmse", s.rmse}, {"mean", s.mean},
          {"median", s.median}, {"p95", s.p95},   {"max", s.max}};
}

json toJson(const evaluation::RelativeError& e, const char* unit) {
  json j = {{std::string("length_") + unit, e.length},
            {"translation_m", toJson(e.translation_m)},
            {"rotation_deg", toJson(e.rotation_deg)},
            {"yaw_deg", toJson(e.yaw_deg)}};
  if (std::string(unit) == "m") j["translation_percent"] = toJson(e.translation_pct);
  return j;
}

json toJson(const evaluation::AlignmentResult& a) {
  const Quat& q = a.T_R_E.q;
  const Vec3& t = a.T_R_E.p;
  return {{"q_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"t_m", {t.x(), t.y(), t.z()}},
          {"scale", a.scale},
          {"note", a.note}};
}

json toJson(const evaluation::ReadReport& r) {
  return {{"poses", r.poses},
          {"malformed", r.malformed},
          {"not_finite", r.not_finite},
          {"zero_quaternions", r.zero_quaternions},
          {"quaternions_normalised", r.quaternions_normalised},
          {"out_of_order", r.out_of_order},
          {"repeated", r.repeated}};
}

json toJson(const evaluation::EvaluationResult& r) {
  json j = {{"matched", r.association.pairs.size()},
            {"before_reference", r.association.before},
            {"after_reference", r.association.after},
            {"in_gap_of_reference", r.association.in_gap},
            {"reference_s", r.association.reference_s},
            {"covered_s", r.association.covered_s},
            {"coverage", r.association.coverage},
            {"path_m", r.path_m},
            {"transform", toJson(r.transform)},
            {"ate_position_m", toJson(r.ate_position_m)},
            {"ate_orientation_deg", toJson(r.ate_orientation_deg)},
            {"end_error_m", r.end_error_m},
            {"end_to_start_m", r.attitudes ? json(r.end_to_start_m) : json(nullptr)},
            {"reference_has_attitudes", r.attitudes},
            {"best_scale", r.best_scale > 0 ? json(r.best_scale) : json(nullptr)},
            {"interpolated", r.association.estimate_interpolated ? "estimate" : "reference"},
            {"rpe_time", toJson(r.rpe_time, "s")}};
  j["rpe_distance"] = json::array();
  for (const evaluation::RelativeError& e : r.rpe_distance)
    j["rpe_distance"].push_back(toJson(e, "m"));
  return j;
}

}  // namespace

ImageCoverage imageCoverage(const std::vector<TimeNs>& images, const Trajectory& estimate) {
  constexpr TimeNs kSame = 1000000;
  ImageCoverage coverage;
  coverage.images = static_cast<long>(images.size());
  for (const TimeNs t : images) {
    const auto next =
        std::lower_bound(estimate.begin(), estimate.end(), t - kSame,
                         [](const StampedPose& pose, TimeNs stamp) { return pose.t < stamp; });
    if (next != estimate.end() && next->t <= t + kSame) ++coverage.covered;
  }
  if (!estimate.empty() && !images.empty()) {
    coverage.first_pose_after_s = toSeconds(estimate.front().t - images.front());
  }
  return coverage;
}

void sayNotes(const Evaluated& e) {
  const char* file = e.file.c_str();
  if (!e.result->attitudes) {
    std::fprintf(stderr,
                 "%s: the %s has positions only: errors of rotation and relative errors are left "
                 "out\n",
                 file, e.read.positions_only ? "estimate" : "reference");
  }
  for (const std::string& hint : e.hints) std::fprintf(stderr, "%s: %s\n", file, hint.c_str());
  const std::string& note = e.result->transform.note;
  if (!note.empty()) std::fprintf(stderr, "%s: %s\n", file, note.c_str());
}

std::string evaluationTable(const std::string& title, const std::vector<Evaluated>& estimates) {
  Table table(estimates);
  std::string text = title + "\n";
  if (table.empty()) return text;
  using R = const evaluation::EvaluationResult&;
  table.add("ATE position rmse [m]", [](R r) { return number(r.ate_position_m.rmse, 4); });
  table.add("ATE position mean [m]", [](R r) { return number(r.ate_position_m.mean, 4); });
  table.add("ATE position median [m]", [](R r) { return number(r.ate_position_m.median, 4); });
  table.add("ATE position p95 [m]", [](R r) { return number(r.ate_position_m.p95, 4); });
  table.add("ATE position max [m]", [](R r) { return number(r.ate_position_m.max, 4); });
  table.add("ATE orientation rmse [deg]", [](R r) {
    return r.attitudes ? number(r.ate_orientation_deg.rmse, 3) : std::string("-");
  });
  table.add("scale of the alignment", [](R r) { return number(r.transform.scale, 5); });
  table.add("best scale (Umeyama)",
            [](R r) { return r.best_scale > 0 ? number(r.best_scale, 5) : std::string("-"); });
  addRelative(&table);
  table.add("end point error [m]", [](R r) { return number(r.end_error_m, 4); });
  table.add("end point relative to start [m]",
            [](R r) { return r.attitudes ? number(r.end_to_start_m, 4) : std::string("-"); });
  table.add("reference path compared [m]", [](R r) { return number(r.path_m, 2); });
  table.add("poses compared", [](R r) { return std::to_string(r.association.pairs.size()); });
  table.add("poses without reference", [](R r) {
    return std::to_string(r.association.before + r.association.after + r.association.in_gap);
  });
  table.add("time compared [s]", [](R r) { return number(r.association.covered_s, 2); });
  table.add("share of the reference's time [%]",
            [](R r) { return number(100 * r.association.coverage, 1); });
  table.addImages();
  return text + table.text();
}

json evaluationJson(const std::string& reference_file, const evaluation::EvaluationOptions& options,
                    const std::vector<Evaluated>& estimates) {
  json list = json::array();
  for (const Evaluated& e : estimates) {
    json j = e.result ? toJson(*e.result) : json::object();
    j["file"] = e.file;
    j["name"] = e.name;
    j["read"] = toJson(e.read);
    j["hints"] = e.hints;
    j["error"] = e.error.empty() ? json(nullptr) : json(e.error);
    if (e.images) {
      j["images"] = {{"total", e.images->images},
                     {"covered", e.images->covered},
                     {"first_pose_after_s", e.images->first_pose_after_s}};
    }
    list.push_back(j);
  }
  return {{"reference", reference_file},
          {"comparison",
           {{"alignment", name(options.alignment)},
            {"association",
             "reference interpolated at the estimate's stamps, a sparse one the other way round"},
            {"max_gap_s", toSeconds(options.association.max_gap)},
            {"text", evaluation::describeComparison(options)}}},
          {"estimates", list}};
}

void writeComparison(const std::string& path, const Trajectory& reference,
                     const std::vector<Evaluated>& estimates, const std::string& subtitle) {
  std::vector<evaluation::NamedResult> results;
  for (const Evaluated& e : estimates) {
    if (e.result) results.push_back({e.name, *e.result});
  }
  if (results.empty()) {
    std::fprintf(stderr, "%s: not written, there is nothing to show\n", path.c_str());
    return;
  }
  writePicture(evaluation::comparisonFigure(reference, results, subtitle), path);
}

std::vector<std::string> shortNames(const std::vector<std::string>& files) {
  for (int parts = 1; parts <= 4; ++parts) {
    std::vector<std::string> names;
    for (const std::string& file : files) {
      const std::filesystem::path path = std::filesystem::path(file).lexically_normal();
      std::filesystem::path name;
      auto it = path.end();
      for (int k = 0; k < parts && it != path.begin(); ++k)
        name = name.empty() ? *--it : *--it / name;
      names.push_back(name.string());
    }
    if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  }
  return files;
}

}  // namespace vir::app
