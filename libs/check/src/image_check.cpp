#include "vir/check/image_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

constexpr double kBlank = 3, kFlat = 10;     // standard deviation of the grey values
constexpr double kDark = 20, kBright = 235;  // mean grey value
constexpr int kFewCorners = 30;
constexpr double kBadS = 1;         // of bad images in a row, to say when
constexpr double kBadForLongS = 3;  // that the IMU alone does not bridge well
constexpr double kFrozenS = 1.5;    // of the same image, so that the IMU can tell motion meanwhile
constexpr long kFewestRepeats = 5;
constexpr double kRepeats = 0.05;        // share of images that come twice, to say so
constexpr TimeNs kAround = 500'000'000;  // of one that does, to know whether the IMU moves
constexpr TimeNs kRim = 250'000'000;     // clocks may be apart, and a motion begins and ends

constexpr const char* kLowContrast = "low_contrast";

/// What is wrong with the light of an image; nothing for a good one.
struct Light {
  const char* kind;
  const char* how;
};

Light lightOf(double mean, double contrast) {
  if (contrast < kBlank) {
    return {"blank", mean < kDark ? "black" : mean > kBright ? "white" : "as good as blank"};
  }
  if (mean < kDark) return {"dark", "dark"};
  if (mean > kBright) return {"bright", "overexposed"};
  return contrast < kFlat ? Light{kLowContrast, "of little contrast"} : Light{"", ""};
}

std::string sizeOf(double mean, double contrast) {
  return "brightness " + num(mean) + ", contrast " + num(contrast) + " of 255 (standard deviation)";
}

}  // namespace

bool ImageCheck::add(TimeNs t, const cv::Mat& gray) {
  if (gray.empty() || gray.type() != CV_8UC1) {
    ++unreadable_;
    return true;
  }
  if (count_++ == 0) {
    width_ = gray.cols;
    height_ = gray.rows;
  }
  sizes_differ_ = sizes_differ_ || gray.cols != width_ || gray.rows != height_;
  cv::Scalar mean, spread;
  cv::meanStdDev(gray, mean, spread);
  cv::Mat small;
  cv::resize(gray, small, {64, 48}, 0, 0, cv::INTER_AREA);
  const bool same = !last_.empty() && cv::countNonZero(small != last_) == 0;
  seen_.push_back({t, static_cast<float>(mean[0]), static_cast<float>(spread[0]), same});
  last_ = small;
  return !same;
}

std::vector<ImageCheck::Stretch> ImageCheck::darkStretches() const {
  std::vector<Stretch> out;
  for (std::size_t i = 0; i < seen_.size();) {
    std::vector<double> means, contrasts;
    std::map<std::pair<std::string, std::string>, int> votes;
    std::size_t k = i;
    for (; k < seen_.size(); ++k) {
      const double mean = static_cast<double>(seen_[k].mean);
      const double contrast = static_cast<double>(seen_[k].contrast);
      const Light light = lightOf(mean, contrast);
      if (*light.kind == '\0') break;
      means.push_back(mean);
      contrasts.push_back(contrast);
      ++votes[{light.kind, light.how}];
    }
    if (k == i) {
      ++i;
      continue;
    }
    const auto most =
        std::max_element(votes.begin(), votes.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    out.push_back({seen_[i].t, seen_[std::min(k, seen_.size() - 1)].t, most->first.first,
                   most->first.second, medianInPlace(&means), medianInPlace(&contrasts)});
    i = k;
  }
  return out;
}

std::vector<ImageCheck::Stretch> ImageCheck::frozenStretches() const {
  std::vector<Stretch> out;
  for (std::size_t i = 1; i < seen_.size(); ++i) {
    if (!seen_[i].same) continue;
    if (!seen_[i - 1].same) out.push_back({seen_[i - 1].t, 0, "frozen", "", 0, 0});
    out.back().to = seen_[i].t;
  }
  return out;
}

std::string ImageCheck::when(const std::vector<Stretch>& stretches) const {
  const Stretch* longest = &stretches[0];
  double total = 0;
  for (const Stretch& s : stretches) {
    total += toSeconds(s.to - s.from);
    if (s.to - s.from > longest->to - longest->from) longest = &s;
  }
  std::string out = "for " + num(toSeconds(longest->to - longest->from)) + " s, from " +
                    num(toSeconds(longest->from - seen_[0].t), 4) + " s after the first image on";
  const std::size_t more = stretches.size() - 1;
  if (more > 0) {
    out += ", and " + std::to_string(more) + (more == 1 ? " more time: " : " more times: ") +
           num(total) + " s in all";
  }
  return out;
}

void ImageCheck::checkSize(int expected_width, int expected_height,
                           std::vector<Finding>* out) const {
  const std::string size = std::to_string(width_) + "x" + std::to_string(height_);
  const bool fits = expected_width == 0 || (width_ == expected_width && height_ == expected_height);
  if (fits && !sizes_differ_) return;
  out->push_back({Severity::unusable, "image_size", label_,
                  sizes_differ_ ? "images have several sizes"
                                : "images have another size than the calibration",
                  size + (fits ? ""
                               : ", calibration " + std::to_string(expected_width) + "x" +
                                     std::to_string(expected_height)),
                  "give the calibration of this size"});
}

void ImageCheck::checkLight(bool further, const std::vector<Stretch>& frozen,
                            std::vector<Finding>* out) const {
  std::vector<double> means, contrasts;
  for (const Seen& s : seen_) {
    means.push_back(static_cast<double>(s.mean));
    contrasts.push_back(static_cast<double>(s.contrast));
  }
  const double mean = medianInPlace(&means), contrast = medianInPlace(&contrasts);
  const std::string evidence = "median " + sizeOf(mean, contrast);
  if (contrast < kFlat) {
    const bool blank = contrast < kBlank;
    out->push_back(
        {blank ? Severity::unusable : Severity::doubtful, blank ? "blank" : "low_contrast", label_,
         blank ? "images are as good as blank" : "images have little contrast", evidence,
         "for 12 to 16 bit cameras import again from the original images, which stretches "
         "them; else expose longer"});
    return;
  }
  if (mean < kDark || mean > kBright) {
    out->push_back({Severity::doubtful, mean < kDark ? "dark" : "bright", label_,
                    mean < kDark ? "images are dark" : "images are overexposed", evidence,
                    "change the exposure"});
    return;
  }
  std::map<std::string, std::vector<Stretch>> stretches;
  for (const Stretch& s : darkStretches()) {
    const bool hangs =
        s.kind == kLowContrast && std::any_of(frozen.begin(), frozen.end(), [&](const Stretch& f) {
          const TimeNs both = std::min(f.to, s.to) - std::max(f.from, s.from);
          return both > (s.to - s.from) / 2;
        });
    if (toSeconds(s.to - s.from) >= kBadS && !hangs) stretches[s.kind].push_back(s);
  }
  for (const auto& [kind, of_kind] : stretches) {
    const bool long_one = std::any_of(of_kind.begin(), of_kind.end(), [](const Stretch& s) {
      return toSeconds(s.to - s.from) >= kBadForLongS;
    });
    out->push_back({long_one ? Severity::doubtful : Severity::note, kind, label_,
                    "images are " + of_kind[0].how + " " + when(of_kind),
                    "there median " + sizeOf(of_kind[0].mean, of_kind[0].contrast) + "; of all " +
                        sizeOf(mean, contrast),
                    !long_one ? std::string()
                              : std::string("look for what covers, blinds or stops the camera "
                                            "there; meanwhile a run has ") +
                                    (further ? "the other cameras"
                                             : "the IMU alone, which carries on for some "
                                               "seconds")});
  }
}

/// For so long that the IMU can tell motion meanwhile; shorter ones count as `repeats`.
std::vector<ImageCheck::Stretch> ImageCheck::stuckStretches(const Moves& moves,
                                                            long* repeats) const {
  std::vector<Stretch> stuck;
  std::size_t at = 0;
  for (const Stretch& s : frozenStretches()) {
    if (toSeconds(s.to - s.from) < kFrozenS) {
      // Without noise, images of what stands still are alike.
      const bool still = moves && !moves(s.from - kAround, s.to + kAround).value_or(true);
      for (; at < seen_.size() && seen_[at].t <= s.to; ++at) {
        if (seen_[at].same && seen_[at].t > s.from && !still) ++*repeats;
      }
      continue;
    }
    const auto moving = moves ? moves(s.from + kRim, s.to - kRim) : std::nullopt;
    if (moving.value_or(false)) stuck.push_back(s);
  }
  // Black ones are all alike; what only has little contrast is not.
  const auto bad = darkStretches();
  const auto covered = [&](const Stretch& s) {
    return std::any_of(bad.begin(), bad.end(), [&](const Stretch& b) {
      return b.kind != kLowContrast && b.from <= s.from && b.to >= s.to;
    });
  };
  stuck.erase(std::remove_if(stuck.begin(), stuck.end(), covered), stuck.end());
  return stuck;
}

void ImageCheck::checkFrozen(const std::vector<Stretch>& stuck, long repeats,
                             std::vector<Finding>* out) const {
  if (!stuck.empty()) {
    out->push_back({Severity::doubtful, "frozen", label_,
                    "the same image comes again and again " + when(stuck),
                    "meanwhile the IMU moves",
                    "the camera or its driver hung: leave the copies out, or that stretch"});
  } else if (repeats >= kFewestRepeats &&
             static_cast<double>(repeats) > kRepeats * static_cast<double>(count_)) {
    out->push_back(
        {Severity::doubtful, "frozen", label_,
         (2 * repeats > count_   ? "most"
          : 5 * repeats > count_ ? "many"
                                 : "some") +
             std::string(" images repeat the one before"),
         std::to_string(repeats) + " of " + std::to_string(count_) + ", though the images change",
         "leave the copies out, or record at the camera's own rate"});
  }
}

std::vector<Finding> ImageCheck::findings(int expected_width, int expected_height,
                                          const Moves& moves, bool further) const {
  std::vector<Finding> out;
  if (unreadable_ > 0) {
    out.push_back(
        {unreadable_ > count_ / 20 ? Severity::unusable : Severity::doubtful, "unreadable", label_,
         "images cannot be loaded",
         std::to_string(unreadable_) + " of those looked at; the first: " + first_unreadable_,
         "check the files; external images must lie beside the rawlog"});
  }
  if (count_ == 0) return out;
  checkSize(expected_width, expected_height, &out);
  const std::size_t before_light = out.size();
  long repeats = 0;
  const std::vector<Stretch> stuck = stuckStretches(moves, &repeats);
  checkLight(further, stuck, &out);
  checkFrozen(stuck, repeats, &out);
  const bool flat =
      std::any_of(out.begin() + static_cast<std::ptrdiff_t>(before_light), out.end(),
                  [](const Finding& f) { return f.kind == "blank" || f.kind == "low_contrast"; });
  if (!corners_.empty() && median(corners_) < kFewCorners && !flat) {
    out.push_back({Severity::doubtful, "few_corners", label_, "there is little to follow",
                   "median of " + std::to_string(median(corners_)) + " corners an image",
                   "more texture, more light, or a sharper lens"});
  }
  return out;
}

}  // namespace vir::check
