#pragma once
/// What goes over the socket while estimating: JSON, a line each (docs/live.md).
#include <string>

#include "vir/team/peer_result.h"
#include "vir/types/anchor.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir::app {

/// {"type":"pose",...}: propagated, per reading of the IMU.
std::string poseLine(const State& state);
/// {"type":"estimate",...}: per image.
std::string estimateLine(const StateEstimate& estimate);
/// {"type":"anchor",...}.
std::string anchorLine(TimeNs t, const Anchor& anchor);
/// {"type":"survey",...}: how a survey of the anchors lies, p_S = Rz(yaw) p_W + t.
std::string surveyLine(TimeNs t, const SurveyFit& survey);
/// {"type":"peer",...}: another robot: how its world lies, p = Rz(yaw) p_peer + t, and where it is
/// in this robot's world as far as that is known.
std::string peerLine(TimeNs t, const team::PeerResult& peer);

}  // namespace vir::app
