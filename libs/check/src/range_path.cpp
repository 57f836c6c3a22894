#include "vir/check/range_path.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "range_scale.h"
#include "text.h"
#include "vir/core/length_units.h"
#include "vir/core/order_statistics.h"
#include "vir/ranging/survey_match.h"

namespace vir::check {
namespace {

constexpr double kDoubtful = 0.15;        // [m] of bias
constexpr double kDoubtfulOffset = 0.03;  // [s]
constexpr double kSigmas = 5;             // of an estimate, to speak against what is given
constexpr double kTellingSigma = 0.1;     // [m] of a bias, to note it
// What is known less well may as well come from an anchor that moves, as another robot does.
constexpr double kKnownOffset = 0.1, kKnownBias = 0.25;  // [s], [m]
constexpr double kDisplaced = 0.5;                       // [m] of an anchor
constexpr double kMisfit = 1;                            // [m] of spread about the best anchor
constexpr double kUnitGain = 25, kUnitRatio = 1.5, kPlaceGain = 15;
constexpr double kOdometryGap = 1.4;  // factor between two units that an odometry tells apart
constexpr double kFarSigmas = 4, kFarAnyway = 0.1;        // [m] of one range
constexpr double kNoteLonger = 0.05, kDoubtLonger = 0.2;  // share of ranges
constexpr TimeNs kOdometrySpan = 60'000'000'000;

struct Fit {
  std::uint64_t id = 0;
  const std::vector<Range>* ranges = nullptr;
  AnchorFit free;               ///< by the ranges alone
  std::optional<AnchorFit> at;  ///< with the anchor where it is said to be, if that fits
  std::optional<Vec3> given;
  const AnchorFit& best() const { return at ? *at : free; }
  bool displaced() const { return given && !at; }
};

using Lists = std::map<std::uint64_t, std::vector<Range>>;

std::vector<Fit> fitAll(const KnownPath& path, const Lists& lists, double unit_m) {
  std::vector<Fit> out;
  for (const auto& [id, ranges] : lists) {
    Fit f;
    f.id = id;
    f.ranges = &ranges;
    f.free = fitAnchor(path, ranges, unit_m);
    if (f.free.found) out.push_back(std::move(f));
  }
  return out;
}

/// The unit in which the ranges fit the path; metres unless another one is far better.
const LengthUnit& unitOf(const KnownPath& path, const Lists& lists, double least_factor,
                         std::vector<Fit>* fits) {
  const LengthUnit* best = &kLengthUnits[0];
  const std::vector<Fit> in_metres = fitAll(path, lists, 1);
  *fits = in_metres;
  double highest = 0;
  for (const LengthUnit& unit : kLengthUnits) {
    if (unit.in_m == 1 || unit.in_m * least_factor > 1) continue;
    std::vector<Fit> others = fitAll(path, lists, unit.in_m);
    if (others.size() != in_metres.size()) continue;
    double gain = 0, weight = 0;
    for (std::size_t i = 0; i < others.size(); ++i) {
      const AnchorFit &here = in_metres[i].free, &there = others[i].free;
      const double w = there.independent;
      gain += w * std::log(here.noise_m / (there.noise_m / unit.in_m));
      weight += w;
    }
    const bool clear = gain > kUnitGain && gain > weight * std::log(kUnitRatio);
    if (!clear || gain <= highest) continue;
    highest = gain;
    best = &unit;
    *fits = std::move(others);
  }
  return *best;
}

Finding unitFinding(const std::string& label, const LengthUnit& unit,
                    const std::vector<Fit>& fits) {
  std::vector<double> noise;
  for (const Fit& f : fits) noise.push_back(f.free.noise_m);
  const std::string name = unit.name;
  return {Severity::unusable,
          "ranges_in_" + name,
          label,
          std::string("the ranges are in ") + unit.in_words + ", not in metres",
          "taken as " + std::string(unit.in_words) + " they fit the path to " +
              num(medianInPlace(&noise)) + " m; taken as metres they fit no anchor anywhere",
          "import with --set euroc.range_unit=" + name + " (csv.range_unit for tables, unit=" +
              name + " in --topic range= of a bag), or multiply them by " + num(unit.in_m, 4)};
}

void dropMisfits(std::vector<Fit>* fits) {
  const auto misfit = [](const Fit& f) { return f.free.noise_m >= kMisfit; };
  fits->erase(std::remove_if(fits->begin(), fits->end(), misfit), fits->end());
}

/// Ranges in proportion too long or too short are a unit of their own; taken as right from then on.
/// Returns metres per unit.
double takeScale(const std::string& label, const KnownPath& path, const Lists& lists, double unit_m,
                 const GivenAnchors& anchors, std::vector<Fit>* fits, std::vector<Finding>* out) {
  std::vector<AnchorFit> at_places;
  std::vector<const AnchorFit*> free, held;
  for (const Fit& f : *fits) {
    free.push_back(&f.free);
    const auto known = anchors.truth.find(f.id);
    if (known == anchors.truth.end()) continue;
    at_places.push_back(fitAnchor(path, *f.ranges, unit_m, known->second));
  }
  for (const AnchorFit& f : at_places) {
    if (f.found) held.push_back(&f);
  }
  // Known places tell it better, but they may be in another frame.
  RangeScale scale = commonScale(held, true);
  if (!scale.found || held.size() < fits->size()) scale = commonScale(free, false);
  if (!scale.found) return unit_m;
  const double percent = 100 * scale.error;
  out->push_back(
      {Severity::doubtful, "range_scale", label,
       "the ranges are too " + std::string(percent > 0 ? "long" : "short") + " by " +
           num(std::abs(percent), 2) + " % of the distance",
       "so they fit the path best, sigma " + num(100 * scale.sigma, 1) + " %, by " +
           std::to_string(scale.anchors) + (scale.anchors == 1 ? " anchor" : " anchors"),
       "import with --set " + std::string(kDriver) +
           ".range_factor=" + num(1 / (1 + scale.error), 4) +
           ", unless it is the ground truth whose scale is "
           "off; a radio that counts time with a wrong clock, or another speed of light, does it"});
  const double right_m = unit_m / (1 + scale.error);
  *fits = fitAll(path, lists, right_m);
  dropMisfits(fits);
  return right_m;
}

/// Whether the given places hold; `at` and `given` of the fits.
void holdAgainst(const KnownPath& path, const GivenAnchors& anchors, double unit_m,
                 std::vector<Fit>* fits) {
  for (Fit& f : *fits) {
    const auto known = anchors.truth.find(f.id);
    if (known == anchors.truth.end()) continue;
    f.given = known->second;
    const AnchorFit at = fitAnchor(path, *f.ranges, unit_m, known->second);
    if (!at.found) continue;
    const double gain = f.free.independent * std::log(at.noise_m / f.free.noise_m);
    const bool far = (f.free.p_W - known->second).norm() > kDisplaced;
    if (!(far && gain > kPlaceGain)) f.at = at;
  }
}

std::string list(const std::vector<const Fit*>& fits) {
  std::string out = fits.size() == 1 ? "anchor " : "anchors ";
  for (std::size_t i = 0; i < fits.size(); ++i) {
    out += (i > 0 ? ", " : "") + std::to_string(fits[i]->id);
  }
  return out;
}

std::string text(const Vec3& p) {
  return "(" + num(p.x()) + ", " + num(p.y()) + ", " + num(p.z()) + ") m";
}

/// The anchor of the table at which this one is.
std::optional<std::uint64_t> isWhereThatIs(const Fit& f, const GivenAnchors& anchors) {
  for (const auto& [id, p] : anchors.truth) {
    if (id != f.id && (f.free.p_W - p).norm() < kDisplaced) return id;
  }
  return std::nullopt;
}

void addPlaces(const std::string& label, const std::vector<Fit>& fits, const GivenAnchors& anchors,
               std::vector<Finding>* out) {
  std::vector<const Fit*> displaced;
  long known = 0;
  for (const Fit& f : fits) {
    if (f.given) ++known;
    if (f.displaced()) displaced.push_back(&f);
  }
  if (displaced.size() > 2 && static_cast<long>(displaced.size()) == known) {
    const Fit& f = *displaced.front();
    out->push_back({Severity::doubtful, "anchor_place", label,
                    "none of the anchors is where the table of true anchors has it",
                    list(displaced) + "; the ranges along the true path put anchor " +
                        std::to_string(f.id) + " at " + text(f.free.p_W) + ", the table at " +
                        text(*f.given),
                    "give the anchors in the ground truth's frame [m]"});
    return;
  }
  for (const Fit* f : displaced) {
    const auto other = isWhereThatIs(*f, anchors);
    out->push_back(
        {Severity::doubtful, "anchor_place", label,
         "anchor " + std::to_string(f->id) + " is not where the table of true anchors has it" +
             (other ? ", but where it has anchor " + std::to_string(*other) : ""),
         "the ranges along the true path put it at " + text(f->free.p_W) + ", the table at " +
             text(*f->given) + ", " + num((f->free.p_W - *f->given).norm()) + " m away",
         other ? "exchange the ids in the table of anchors, or those of the radios"
               : "measure it again, in the ground truth's frame [m]; until then its error "
                 "in summary.json means nothing"});
  }
}

/// A survey in a frame of its own is held against the path as a whole.
void addSurvey(const std::string& label, const std::vector<Fit>& fits, const GivenAnchors& anchors,
               std::vector<Finding>* out) {
  std::vector<ranging::SurveyRange> ranges;
  for (std::size_t a = 0; a < anchors.survey.size(); ++a) {
    for (const Fit& f : fits) {
      if (f.id != anchors.survey[a].id) continue;
      for (std::size_t i = 0; i < f.free.antennas_W.size(); ++i) {
        ranges.push_back({a, f.free.antennas_W[i], f.free.ranges_m[i], f.free.noise_m});
      }
    }
  }
  if (anchors.survey.size() < 2 || ranges.empty()) return;
  ranging::SurveyMatchOptions options;
  options.drift_ratio = 1e-4;
  options.scale_sigma = 1e-4;
  options.uncalibrated_bias_sigma_m = 0.7;
  options.thorough = true;
  const auto match = ranging::matchSurvey(ranges, anchors.survey, options);
  for (const ranging::SurveyFinding& f : match.findings) {
    out->push_back({Severity::doubtful, "anchor_place", label, ranging::describe(f, anchors.survey),
                    "by the ranges along the true path",
                    "mend x_anchors.csv, or what tells the anchors' places, before --anchors"});
  }
  if (match.findings.empty() && match.status == SurveyStatus::contradicted) {
    out->push_back({Severity::doubtful, "anchor_place", label,
                    "the anchors are not where the recording says, however its frame lies",
                    match.reason, "give their places with `run --anchors FILE`"});
  }
}

/// One finding for anchors that agree, else one for each.
void addOffsets(const std::string& label, const std::vector<Fit>& fits, std::vector<Finding>* out) {
  std::vector<const Fit*> off;
  std::vector<double> offsets, sigmas;
  for (const Fit& f : fits) {
    const AnchorFit& b = f.best();
    if (std::abs(b.offset_s) < kDoubtfulOffset || b.offset_sigma_s > kKnownOffset ||
        std::abs(b.offset_s) < kSigmas * b.offset_sigma_s) {
      continue;
    }
    off.push_back(&f);
    offsets.push_back(b.offset_s);
    sigmas.push_back(b.offset_sigma_s);
  }
  if (off.empty()) return;
  const double offset = medianInPlace(&offsets);
  const bool late = offset < 0;
  out->push_back(
      {Severity::doubtful, "range_time_offset", label,
       std::string("the stamps of the ranges are too ") + (late ? "late" : "early") + " by " +
           num(std::abs(offset)) + " s" + (off.size() < fits.size() ? " (" + list(off) + ")" : ""),
       "so they fit the path best, sigma " + num(medianInPlace(&sigmas), 2) + " s",
       "import with --set " + std::string(kDriver) + ".range_time_offset_s=" + num(offset) +
           ", unless it is the path's clock that is off; were they stamped on arrival? A bag may "
           "have their own time in a field (stamp=FIELD in --topic range=)"});
}

void addBiases(const std::string& label, const std::vector<Fit>& fits, std::vector<Finding>* out) {
  std::vector<const Fit*> wrong;
  for (const Fit& f : fits) {
    const AnchorFit& b = f.best();
    const bool doubtful = std::abs(b.bias_m) > kDoubtful && b.bias_sigma_m < kKnownBias &&
                          std::abs(b.bias_m) > kSigmas * b.bias_sigma_m;
    if (doubtful) wrong.push_back(&f);
    if (!doubtful && b.bias_sigma_m > kTellingSigma) continue;
    const std::string anchor = "anchor " + std::to_string(f.id);
    out->push_back(
        {doubtful ? Severity::doubtful : Severity::note, "range_bias", label,
         anchor + (doubtful ? ": the ranges are too " +
                                  std::string(b.bias_m > 0 ? "long" : "short") + " throughout"
                            : ": constant error against the ground truth"),
         num(b.bias_m) + " m, sigma " + num(b.bias_sigma_m, 2) + " m, by " +
             std::to_string(b.used) + " ranges along the true path",
         doubtful ? "calibrate the radios (vir-slam calibrate uwb), or " +
                        std::string(b.bias_m > 0 ? "take " : "add ") + num(std::abs(b.bias_m)) +
                        (b.bias_m > 0 ? " m off" : " m")
                  : ""});
  }
}

/// Ranges that went round something are too long, hardly ever too short.
void addLengthened(const std::string& label, const std::vector<Fit>& fits,
                   std::vector<Finding>* out) {
  for (const Fit& f : fits) {
    const AnchorFit& b = f.best();
    const double far = kFarSigmas * b.noise_m + kFarAnyway;
    long longer = 0, shorter = 0;
    std::vector<double> by;
    for (std::size_t i = 0; i < b.antennas_W.size(); ++i) {
      const double rest = b.ranges_m[i] - (b.p_W - b.antennas_W[i]).norm() - b.bias_m;
      if (rest > far) ++longer, by.push_back(rest);
      if (rest < -far) ++shorter;
    }
    const double share = double(longer) / std::max(double(b.antennas_W.size()), 1.0);
    if (share < kNoteLonger || longer < 3 * shorter) continue;
    out->push_back({share > kDoubtLonger ? Severity::doubtful : Severity::note, "range_lengthened",
                    label,
                    "anchor " + std::to_string(f.id) + ": " + num(100 * share, 2) +
                        " % of the ranges are far too long, as without line of sight",
                    "by " + num(medianInPlace(&by)) + " m in the median, " + num(far, 2) +
                        " m or more; " + std::to_string(shorter) + " too short by as much",
                    "put the anchor where the robot sees it, or several anchors; a run leaves out "
                    "what sticks out, but not what is wrong for long"});
  }
}

void addMisfits(const std::string& label, const std::vector<Fit>& fits, std::vector<Finding>* out) {
  for (const Fit& f : fits) {
    if (f.free.noise_m < kMisfit) continue;
    out->push_back(
        {Severity::doubtful, "range_misfit", label,
         "the ranges to anchor " + std::to_string(f.id) +
             " do not fit the true path, whatever unit, offset and place are tried",
         "spread " + num(f.free.noise_m) + " m about the best anchor there is",
         "does the anchor move, do several share one id, or does the ground truth belong "
         "to another recording?"});
  }
}

}  // namespace

void RangePathCheck::add(const Range& r) {
  if (!std::isfinite(r.range_m) || r.range_m <= 0) return;
  if (anchors_.size() >= kMostAnchors && anchors_.count(r.anchor) == 0) return;
  anchors_.try_emplace(r.anchor, kShown).first->second.add(r);
}

std::vector<Finding> RangePathCheck::againstTruth(const KnownPath& path,
                                                  const GivenAnchors& anchors) const {
  std::vector<Finding> out;
  Lists lists;
  for (const auto& [id, ranges] : anchors_) lists[id] = ranges.values();
  std::vector<Fit> fits;
  const LengthUnit& unit = unitOf(path, lists, 1, &fits);
  if (fits.empty()) return out;
  if (unit.in_m != 1) out.push_back(unitFinding(label_, unit, fits));
  addMisfits(label_, fits, &out);
  dropMisfits(&fits);
  const double unit_m = takeScale(label_, path, lists, unit.in_m, anchors, &fits, &out);
  holdAgainst(path, anchors, unit_m, &fits);
  addPlaces(label_, fits, anchors, &out);
  if (anchors.truth.empty()) addSurvey(label_, fits, anchors, &out);
  addOffsets(label_, fits, &out);
  addBiases(label_, fits, &out);
  addLengthened(label_, fits, &out);
  return out;
}

std::vector<Finding> RangePathCheck::againstOdometry(const KnownPath& path) const {
  std::vector<Finding> out;
  if (path.empty()) return out;
  Lists lists;
  for (const auto& [id, ranges] : anchors_) {
    for (const Range& r : ranges.values()) {
      if (r.t <= path.start() + kOdometrySpan) lists[id].push_back(r);
    }
  }
  std::vector<Fit> fits;
  const LengthUnit& unit = unitOf(path, lists, kOdometryGap, &fits);
  if (unit.in_m != 1) out.push_back(unitFinding(label_, unit, fits));
  addOffsets(label_, fits, &out);
  return out;
}

}  // namespace vir::check
