#pragma once
/// The team on the air over DDS. What works with DDS is a shared object of its own, built where
/// Cyclone DDS is: nothing here needs it.
#include <memory>
#include <string>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/team/peer_report.h"

namespace vir::dds {

/// Section [Dds].
struct LinkOptions {
  int robot = -1;  ///< this robot's number, under which others range to it; -1: no link
  int domain = 0;
  std::string interface = "lo";
  bool multicast = false;
  std::string peers;  ///< addresses with blanks between
  std::string team;   ///< partition; empty: the one without a name
  double rate_hz = 10;
  std::string security;  ///< folder; empty: none
  bool ros2 = false;     ///< standard topics as well
  std::string ros2_namespace;
  std::string config;  ///< a file of Cyclone DDS; empty: what is above
};
void describe(OptionVisitor& v, LinkOptions& o);

/// The settings as Cyclone DDS reads them (XML), or what is in the file `config`. Throws
/// std::runtime_error if that cannot be read.
std::string domainConfig(const LinkOptions& options);

class Link : public team::PeerLink {};

/// What the shared object `libvir_dds.so` has as a C function `virOpenDdsLink`. Throws
/// std::runtime_error: no such interface, no right to a port, security files that are missing. What
/// DDS itself warns of goes to the sink, from any thread, as long as the link is there.
using OpenLink = Link* (*)(const LinkOptions&, const LogSink&);

}  // namespace vir::dds
