#pragma once
/// What our MCAP files say of a topic, so that its messages come back as what they were.

namespace vir::rawlog {

/// The sensor's label in the rawlog.
constexpr const char* kTopicLabel = "vir_slam_label";
/// What the anchor in that label is called, where that is no number that fits.
constexpr const char* kTopicAnchor = "vir_slam_anchor";
/// Of poses of another robot: its antenna in its body, three numbers [m].
constexpr const char* kTopicAntenna = "vir_slam_antenna";

}  // namespace vir::rawlog
