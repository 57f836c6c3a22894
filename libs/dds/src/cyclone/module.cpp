/// What the program finds in the shared object.
#include "cyclone/cyclone_link.h"
#include "cyclone/ros_topics.h"

extern "C" __attribute__((visibility("default"))) vir::dds::Link* virOpenDdsLink(
    const vir::dds::LinkOptions& options, const vir::LogSink& log) {
  return vir::dds::openCycloneLink(options, log).release();
}

extern "C" __attribute__((visibility("default"))) vir::dds::RosTopics* virOpenRosTopics(
    const vir::dds::LinkOptions& options, const vir::LogSink& log) {
  return vir::dds::openRosTopics(options, log).release();
}
