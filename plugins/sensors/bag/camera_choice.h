#pragma once
/// Which topics of images are cameras, and which are the same camera once more.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "survey.h"

namespace vir::bag {

/// `/cam/image_raw/compressed` is `/cam/image_raw` in other bytes.
std::string baseOf(const std::string& topic);
/// Images of something else than light, by their name.
bool isNoPicture(const TopicInfo& t);

struct CameraChoice {
  /// In the order of their labels: the first has those of its kind behind it (left before right,
  /// cam0 before cam1, infra1 before infra2), then come the others by their names.
  std::vector<const TopicInfo*> taken;
  std::map<std::string, std::string> left_out;  ///< why, by topic: a part of a sentence
};

/// What keeps each of these topics (in the order of their labels) from being used as a camera
/// beside the first; empty where nothing does.
using Lacks = std::function<std::vector<std::string>(const std::vector<std::string>& topics)>;

/// The cameras that can be told apart by the names of their topics or frames. Of those beside the
/// first only the ones that lack nothing; with `all_of_a_kind` also those that are called as the
/// first is but for a number or a side.
/// `named`: topics that the calibration calls by name; these come first.
CameraChoice chooseCameras(const Survey& survey, const std::vector<std::string>& named,
                           const Lacks& lacks, bool all_of_a_kind);

}  // namespace vir::bag
