#pragma once
/// What the images of robots have in common, by the maps that their runs have left.
#include "robots/rendezvous_robots.h"
#include "vir/team/meeting.h"

namespace vir::app {

/// The map of a finished run: the one given (`--map NAME=FILE`), else the one that its used.ini
/// says it has saved, there or in the run's folder. Empty: there is none. Throws UsageError for one
/// that is given and cannot be read.
std::string mapOfFinished(const std::string& given, const std::string& folder);

/// In the folder of a robot that is estimated here.
constexpr const char* kMapName = "map.virmap";

/// Such a robot keeps a map if its estimator looks for places and it has images: its settings then
/// say so. `used`: what they are without.
void keepMap(const std::string& used, const results::ResultsFolder& own, RobotFile* robot);

/// Of every pair whose maps are there. The later-named robot's images are read once more, to be
/// compared with the other's map. What cannot be used is told to `log`.
team::PlacesOfPairs placesInCommon(const Prepared& prepared, const results::ResultsFolder& folder,
                                   const std::vector<team::RobotRecord>& records,
                                   const LogSink& log);

}  // namespace vir::app
