#pragma once
#include <memory>

#include "vir/dds/ros_topics.h"

namespace vir::dds {

/// Throws as OpenRosTopics.
std::unique_ptr<RosTopics> openRosTopics(const LinkOptions& options, const LogSink& log = {});

}  // namespace vir::dds
