#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "vir/geometry/so3.h"
#include "vir/types/survey.h"

namespace vir::app {

/// `x` of `x.rawlog` and `x.rawlog.gz`; any other name loses its extension.
std::string stemOfRawlog(const std::string& rawlog);

/// The ini that `import` or `simulate` left beside a rawlog (`x.rawlog` -> `x.ini`), or empty. A
/// file of that name which somebody else wrote is none of our business.
std::string companionOf(const std::string& rawlog);

/// Which number the importer gave to which anchor's name, by the remarks in the ini beside a
/// rawlog: `name=number`, blanks between; empty where there are none.
std::string anchorNamesOf(const std::string& rawlog);

/// The same by number: what anchors were called in the recording. Empty where all were numbers that
/// fit.
using AnchorTexts = std::map<std::uint64_t, std::string>;
AnchorTexts anchorTextsOf(const std::string& rawlog);
/// From remarks as they are in that ini.
AnchorTexts anchorTextsIn(const std::string& ini);
/// Numbers of these in a text for people become what they were called.
void callAnchors(const AnchorTexts& texts, std::string* text);
/// What this one was called, else its number.
std::string anchorText(const AnchorTexts& texts, std::uint64_t id);

/// Where anchors truly are, by id.
struct AnchorTable {
  std::string path;  ///< empty if there is no such file
  std::map<std::uint64_t, Vec3> anchors;
  int bad_lines = 0;  ///< not `id,x,y,z`, not finite, or an id for the second time: left out
};

/// The table beside a rawlog (`x.rawlog` -> `x_anchors_truth.csv`), written by `import` or by hand.
AnchorTable anchorsTruthOf(const std::string& rawlog);

/// Where the recording says that its anchors are, in a frame of their own, by the table that
/// `import` left beside a rawlog (`x.rawlog` -> `x_anchors.csv`); empty where there is none, or
/// none that can be read: who holds a run to it (`--anchors`) is told why.
std::vector<SurveyedAnchor> surveyOf(const std::string& rawlog);

}  // namespace vir::app
