/// What the bounds of single settings cannot say.
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>

#include "range_layer_impl.h"
#include "vir/core/ini_writer.h"
#include "vir/core/option_check.h"
#include "vir/estimator/odometry_range_estimator.h"
#include "vir/estimator/visual_inertial_estimator.h"

namespace vir::estimator {
namespace {

constexpr double kLargestPriorSigma = 1e6;  // [m]

void checkPriors(const std::vector<double>& list) {
  std::string text;
  for (const double x : list) text += (text.empty() ? "" : " ") + numberText(x);
  const auto refuse = [&](const std::string& problem) {
    refuseSetting("Ranges", "anchor_prior", text, problem);
  };
  if (list.size() % 5 != 0) {
    refuse(std::to_string(list.size()) +
           " numbers; allowed: five for every anchor, id x y z sigma");
  }
  std::set<double> ids;
  for (std::size_t i = 0; i + 4 < list.size(); i += 5) {
    const double id = list[i], sigma = list[i + 4];
    if (!(id >= 0 && id <= std::numeric_limits<int>::max()) || id != std::floor(id)) {
      refuse(
          "an anchor's id is " + numberText(id) +
          "; allowed: a whole number from 0 to 2147483647 (five numbers for every anchor, id x y "
          "z sigma)");
    }
    if (!ids.insert(id).second) {
      refuse("anchor " + numberText(id) + " is there twice; allowed: one prior for every anchor");
    }
    if (!(sigma >= kLeastPriorSigma && sigma <= kLargestPriorSigma)) {
      refuse("the sigma of anchor " + numberText(id) + " is " + numberText(sigma) +
             "; allowed: a number from " + numberText(kLeastPriorSigma) + " to " +
             numberText(kLargestPriorSigma) + " m");
    }
  }
}

void checkSurvey(const std::vector<SurveyedAnchor>& survey) {
  std::set<std::uint64_t> ids;
  for (const SurveyedAnchor& a : survey) {
    const auto refuse = [&](const std::string& problem) {
      refuseSetting("Ranges", "surveyed_anchors", "anchor " + std::to_string(a.id), problem);
    };
    if (a.id > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
      refuse("allowed: ids from 0 to 2147483647");
    }
    if (!ids.insert(a.id).second) refuse("is there twice; allowed: one place for every anchor");
    if (!a.p_S.allFinite()) refuse("is at a place that is no number");
    if (!(a.sigma_m >= kLeastPriorSigma && a.sigma_m <= kLargestPriorSigma)) {
      refuse("has sigma " + numberText(a.sigma_m) + "; allowed: a number from " +
             numberText(kLeastPriorSigma) + " to " + numberText(kLargestPriorSigma) + " m");
    }
  }
}

/// A setting that must not be above another.
void atMost(const char* section, const char* key, double value, const std::string& other,
            double limit, const char* why) {
  if (value <= limit) return;
  refuseSetting(section, key, numberText(value),
                std::string(why) + "; allowed: at most " + other + " = " + numberText(limit));
}

/// Of the visual-inertial estimator, whose scale is held at 1 unless it is asked for.
void checkScale(const window::LongWindowOptions& o) {
  if (o.scale_sigma <= 0 && o.scale_walk_per_sqrt_m > 0) {
    refuseSetting("LongWindow", "scale_walk_per_sqrt_m", numberText(o.scale_walk_per_sqrt_m),
                  "a scale that is held at 1 does not wander; allowed: 0, or scale_sigma above 0");
  }
  if (o.scale_sigma > 0 && o.mode == window::LongWindowMode::position) {
    refuseSetting("LongWindow", "scale_sigma", numberText(o.scale_sigma),
                  "[Estimator] long_window = position knows no scale; allowed: 0");
  }
}

/// Three numbers of the IMU, each small: what is larger is a wrong unit or axis.
void checkThree(const char* key, const std::vector<double>& list) {
  bool good = list.size() == 3;
  std::string text;
  for (const double x : list) {
    good = good && std::abs(x) <= 0.5;
    text += (text.empty() ? "" : " ") + numberText(x);
  }
  if (!good) refuseSetting("Imu", key, text, "allowed: three numbers from -0.5 to 0.5");
}

}  // namespace

void RangeOptions::validate() const {
  checkBounds(*this);
  checkPriors(anchor_prior);
  checkSurvey(survey);
  if (!surveyed_anchors.empty() && survey.empty()) {
    refuseSetting("Ranges", "surveyed_anchors", surveyed_anchors,
                  "named, but no survey has been read; allowed: a file whose anchors are in "
                  "RangeOptions::survey, or none");
  }
  if (!bias_model_file.empty() && bias_model.empty()) {
    refuseSetting("Ranges", "bias_model", bias_model_file,
                  "named, but no model has been read; allowed: a file whose model is in "
                  "RangeOptions::bias_model, or none");
  }
}

void StartupOptions::validate() const {
  checkBounds(*this);
  if (max_span_s <= min_span_s) {
    refuseSetting("Startup", "max_span_s", numberText(max_span_s),
                  "no stretch of images would ever be long enough; allowed: above min_span_s = " +
                      numberText(min_span_s));
  }
  atMost("Startup", "max_scale_sigma", max_scale_sigma, "patient_scale_sigma", patient_scale_sigma,
         "a late start would be no easier than an early one");
}

void RestOptions::validate() const { checkBounds(*this); }
void FailureOptions::validate() const { checkBounds(*this); }
void OdometryOptions::validate() const { checkBounds(*this); }

void EstimatorConfig::validate() const {
  imu.validate();
  tracker.validate();
  startup.validate();
  window.validate();
  long_window.validate();
  ranges.validate();
  rest.validate();
  failure.validate();
  checkBounds(*this);
  atMost("Startup", "min_shared_tracks", startup.min_shared_tracks, "[Tracker] max_tracks",
         tracker.max_tracks, "no image has so many tracks to share");
  atMost("Rest", "min_tracks", rest.min_tracks, "[Tracker] max_tracks", tracker.max_tracks,
         "no image has so many tracks");
  atMost("Startup", "sigma_bias_gyro", startup.sigma_bias_gyro, "[Failure] max_bias_gyro",
         failure.max_bias_gyro, "a start as it expects them would count as a failure");
  atMost("Startup", "sigma_bias_acc", startup.sigma_bias_acc, "[Failure] max_bias_acc",
         failure.max_bias_acc, "a start as it expects them would count as a failure");
  checkScale(long_window);
  checkThree("gyro_gain", gyro_gain);
  checkThree("gyro_axes_rad", gyro_axes_rad);
  checkThree("acc_gain", acc_gain);
}

void OdometryRangeConfig::validate() const {
  odometry.validate();
  long_window.validate();
  ranges.validate();
  if (iterations < 1) {
    throw std::invalid_argument("OdometryRangeConfig: iterations is " + std::to_string(iterations) +
                                "; allowed: at least 1");
  }
}

}  // namespace vir::estimator
