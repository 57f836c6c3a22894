#include <sstream>

#include "vir/core/markup.h"
#include "vir/core/text_file.h"
#include "vir/dds/link.h"

namespace vir::dds {
namespace {

constexpr std::size_t kMostConfig = 1 << 20;  // [byte]

}  // namespace

void describe(OptionVisitor& v, LinkOptions& o) {
  v.section("Dds", "The other robots of a team, over DDS, while recording and estimating");
  v.value("robot", o.robot, {-1, 2147483647},
          "this robot's number, under which the others range to it; -1 = no DDS");
  v.value("domain", o.domain, {0, 232}, "of DDS; robots of one team are in the same");
  v.value("interface", o.interface,
          "of the network, by name or address; lo = this machine only, auto = what DDS chooses");
  v.value("multicast", o.multicast, "find the others by multicast");
  v.value("peers", o.peers,
          "addresses to find others at, with blanks between: without multicast, or beyond it");
  v.value("team", o.team, "only robots of this team hear each other (a partition of DDS)");
  v.value("rate_hz", o.rate_hz, {0.1, 50}, "of the own pose to the others");
  v.value("security", o.security,
          "folder of certificates and permissions as in an enclave of ROS 2; empty: none");
  v.value("ros2", o.ros2, "pose as standard topics of ROS 2, with or without a team");
  v.value("ros2_namespace", o.ros2_namespace,
          "before the names of these topics and frames; empty: none");
  v.value("config", o.config,
          "XML file of Cyclone DDS in place of interface, multicast and peers; empty: these");
}

std::string domainConfig(const LinkOptions& o) {
  if (!o.config.empty()) return readTextFile(o.config, kMostConfig);
  const bool loopback = o.interface == "lo" || o.interface.rfind("127.", 0) == 0;
  std::string interfaces;
  if (loopback) {
    interfaces = "<NetworkInterface address=\"127.0.0.1\"/>";
  } else if (o.interface != "auto") {
    const bool address = o.interface.find_first_not_of("0123456789.") == std::string::npos;
    interfaces = std::string("<NetworkInterface ") + (address ? "address" : "name") + "=\"" +
                 escapedMarkup(o.interface) + "\"/>";
  }
  std::string peers;
  std::istringstream words(o.peers);
  for (std::string peer; words >> peer;) peers += "<Peer address=\"" + escapedMarkup(peer) + "\"/>";
  // Loopback has no multicast everywhere: who is on this machine is asked at each port.
  if (loopback) peers += "<Peer address=\"127.0.0.1\"/>";
  // Several robots on one machine have a port each; as many are looked for at an address.
  return "<CycloneDDS><Domain id=\"any\"><General>" +
         (interfaces.empty() ? "" : "<Interfaces>" + interfaces + "</Interfaces>") +
         "<AllowMulticast>" + (o.multicast && !loopback ? "true" : "false") +
         "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
         "<MaxAutoParticipantIndex>40</MaxAutoParticipantIndex>" +
         (peers.empty() ? "" : "<Peers>" + peers + "</Peers>") +
         "</Discovery></Domain></CycloneDDS>";
}

}  // namespace vir::dds
