#include "survey_files.h"

#include <algorithm>

#include "csv_text.h"
#include "vir/evaluation/trajectory.h"

namespace vir::results {
namespace {

using namespace csv;

constexpr const char* kHeader =
    "id,x,y,z,surveyed_x,surveyed_y,surveyed_z,sigma_m,off_m,heard,used";

std::string anchorLine(const SurveyedResult& a) {
  std::string line = std::to_string(a.given.id);
  for (int i = 0; i < 3; ++i) line += "," + (a.p_S ? csvNumber((*a.p_S)[i]) : std::string());
  for (int i = 0; i < 3; ++i) line += "," + csvNumber(a.given.p_S[i]);
  line += "," + csvNumber(a.given.sigma_m);
  line += "," + (a.p_S ? csvNumber((*a.p_S - a.given.p_S).norm()) : std::string());
  return line + (a.heard ? ",1" : ",0") + (a.used ? ",1" : ",0");
}

void writePath(const ResultsFolder& folder, const char* name, const Pose& T_S_W,
               const Trajectory& in_W) {
  Trajectory in_S;
  in_S.reserve(in_W.size());
  for (const StampedPose& p : in_W) in_S.push_back({p.t, T_S_W * p.T_W_B});
  OutputFile file(folder.file(name));
  evaluation::writeTum(file.stream(), in_S);
  file.close();
}

}  // namespace

bool inSurveyFrame(const SurveyFit& s) {
  const bool turned = std::find(s.open.begin(), s.open.end(), "yaw") == s.open.end();
  return s.status == SurveyStatus::found && turned && s.covariance.allFinite() &&
         s.T_S_W.t_m.allFinite();
}

void writeSurveyFiles(const ResultsFolder& folder, const SurveyFit& survey,
                      const Trajectory& causal, const Trajectory& smoothed) {
  if (!inSurveyFrame(survey)) return;
  const Pose T_S_W = survey.T_S_W.pose();
  writePath(folder, "trajectory_survey.tum", T_S_W, causal);
  writePath(folder, "trajectory_smoothed_survey.tum", T_S_W, smoothed);
  OutputFile file(folder.file("anchors_survey.csv"));
  file.line(kHeader);
  for (const SurveyedResult& a : survey.anchors) file.line(anchorLine(a));
  file.close();
}

std::vector<std::string> surveyWarnings(const SurveyFit& survey) {
  std::vector<std::string> out;
  for (const std::string& finding : survey.findings) out.push_back("survey: " + finding);
  if (survey.status != SurveyStatus::found) {
    out.push_back("survey: not found in the path's world: " + survey.reason +
                  "; there are no results in its frame");
  }
  return out;
}

}  // namespace vir::results
