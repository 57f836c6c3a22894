#pragma once
/// Between team::PeerReport and the type of idl/team.idl.
#include <vector>

#include "team.h"
#include "vir/team/peer_report.h"

namespace vir::dds {

/// A sample with the memory that its sequences point to.
class ReportSample {
 public:
  /// What is beyond the bounds of the sequences is left out.
  explicit ReportSample(const team::PeerReport& report);
  ReportSample(const ReportSample&) = delete;
  ReportSample& operator=(const ReportSample&) = delete;
  const vir_team_Report& sample() const { return sample_; }

 private:
  void addTeam(const team::TeamTold& told);

  vir_team_Report sample_{};
  std::vector<vir_team_Anchor> anchors_;
  std::vector<vir_team_Range> ranges_;
  vir_team_Frame frame_{};
  std::vector<vir_team_Transform> transforms_;
};

/// As it is: nothing is judged here.
team::PeerReport reportOf(const vir_team_Report& sample);

}  // namespace vir::dds
