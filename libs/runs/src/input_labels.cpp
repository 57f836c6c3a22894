#include "vir/runs/input_labels.h"

#include <algorithm>
#include <set>
#include <utility>

#include "vir/rawlog/labels.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::runs {
namespace {

/// What is not there by then may be missing; whether it is needed decides about reading on.
constexpr std::size_t kObservationsAtLeast = 3000;

/// Labels with a meaning that no input of an estimator has.
bool spokenFor(const std::string& label) {
  return label == rawlog::kGroundTruthLabel || label == rawlog::kPeerLabel ||
         rawlog::isBroadcastLabel(label) || rawlog::isDeployedAnchorLabel(label) ||
         rawlog::differenceReferenceOf(label).has_value();
}

std::string listed(const std::set<std::string>& labels, const char* between) {
  std::string out;
  for (const std::string& l : labels) out += (out.empty() ? "" : between) + l;
  return out;
}

class Survey {
 public:
  explicit Survey(const std::vector<roles::EstimatorInput>& inputs)
      : inputs_(inputs), others_(inputs.size()) {
    for (const roles::EstimatorInput& i : inputs) {
      if (i.group > 0) missing_.insert(i.group);
    }
  }
  void add(const mrpt::obs::CObservation& o) {
    bool taken = false;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      if (!roles::matches(inputs_[k], o)) continue;
      taken = true;
      seen_.insert(k);
      missing_.erase(inputs_[k].group);
    }
    if (taken || spokenFor(o.sensorLabel)) return;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      roles::EstimatorInput as_here = inputs_[k];
      as_here.label = o.sensorLabel;
      if (roles::matches(as_here, o)) others_[k].insert(o.sensorLabel);
    }
  }
  bool hasAllNeeded() const { return missing_.empty(); }

  InputLabels result() const {
    InputLabels out;
    noteOtherRanges(&out);
    noteOtherImages(&out);
    noteMissingCameras(&out);
    bool images_told = anyFirstImage();
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      const roles::EstimatorInput& input = inputs_[k];
      if (others_[k].empty() || seen_.count(k) > 0 || input.named) continue;
      const std::string what = name(input.kind), wanted = what + " under the label " + input.label;
      const std::string labels = listed(others_[k], ", ");
      if (input.group == 0) {
        const bool image = input.kind == roles::InputKind::image;
        if (image && std::exchange(images_told, true)) continue;  // several may be asked for
        out.notes.push_back("no " + wanted + ": those under " + labels +
                            " are not used; the label is a setting of the estimator");
      } else if (missing_.count(input.group) == 0) {
        continue;  // another input does for it
      } else if (others_[k].size() > 1) {
        out.notes.push_back("no " + wanted + "; there are " + labels +
                            ": name one in the settings of the estimator");
      } else {
        out.as[labels] = input.label;
        out.notes.push_back("no " + wanted + ": the only ones, under " + labels + ", are taken");
      }
    }
    return out;
  }

 private:
  /// Ranges of further antennas are not taken unasked: their places may not be known.
  void noteOtherRanges(InputLabels* out) const {
    std::string used, others;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      if (inputs_[k].kind != roles::InputKind::ranges) continue;
      if (seen_.count(k) > 0) used += (used.empty() ? "" : " ") + inputs_[k].label;
      others = listed(others_[k], " ");
    }
    if (used.empty() || others.empty()) return;
    out->notes.push_back("ranges under " + used + " are used, those under " + others +
                         " are not: range_label = " + used + " " + others +
                         " takes them too, each with the antenna's place as in the recording");
  }

  void noteOtherImages(InputLabels* out) const {
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      const bool first = inputs_[k].kind == roles::InputKind::image && inputs_[k].group > 0;
      if (!first || seen_.count(k) == 0 || others_[k].empty()) continue;
      const std::string others = listed(others_[k], " ");
      out->notes.push_back("images under " + inputs_[k].label + " are used, those under " + others +
                           " are not: [Estimator] other_cameras = " + others + " takes them too");
    }
  }

  bool anyFirstImage() const {
    for (const std::size_t k : seen_) {
      if (inputs_[k].kind == roles::InputKind::image && inputs_[k].group > 0) return true;
    }
    return false;
  }

  /// Cameras that somebody asked for and that are not there.
  void noteMissingCameras(InputLabels* out) const {
    std::set<std::string> there;
    std::string missing;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      const roles::EstimatorInput& input = inputs_[k];
      if (input.kind != roles::InputKind::image) continue;
      there.insert(others_[k].begin(), others_[k].end());
      if (seen_.count(k) > 0) {
        there.insert(input.label);
      } else if (input.named) {
        missing += (missing.empty() ? "" : " ") + input.label;
      }
    }
    if (missing.empty()) return;
    out->notes.push_back("[Estimator] other_cameras: there are no images under " + missing +
                         " at the beginning of the recording" +
                         (there.empty()
                              ? std::string()
                              : "; there are images under " + listed(there, ", ") +
                                    " (name labels as they are there, with blanks between them)"));
  }

  const std::vector<roles::EstimatorInput>& inputs_;
  std::vector<std::set<std::string>> others_;  // labels that would do, per input
  std::set<std::size_t> seen_;
  std::set<int> missing_;
};

}  // namespace

InputLabels matchLabels(const std::vector<roles::EstimatorInput>& inputs,
                        const std::string& rawlog) {
  rawlog::RawlogReader reader(rawlog);
  Survey survey(inputs);
  for (std::size_t n = 0; n < kObservationsAtLeast || !survey.hasAllNeeded(); ++n) {
    const auto o = reader.next();
    if (!o) break;
    survey.add(*o);
  }
  return survey.result();
}

}  // namespace vir::runs
