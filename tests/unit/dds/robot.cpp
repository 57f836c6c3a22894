/// A robot of a team as a process of its own: tells where it is along a line. What is wrong with it
/// is asked for by name.
///   vir_test_dds_robot NUMBER DOMAIN TEAM REPORTS RATE_HZ [FAULT [SECURITY]]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>

#include "cyclone/cyclone_link.h"
#include "team_on_a_line.h"

int main(int argc, char** argv) {
  using namespace vir;
  if (argc < 6) return 2;
  const std::string fault = argc > 6 ? argv[6] : "";
  dds::LinkOptions options;
  options.robot = std::atoi(argv[1]);
  options.domain = std::atoi(argv[2]);
  options.team = argv[3];
  if (argc > 7) options.security = argv[7];
  const int reports = std::atoi(argv[4]);
  const double period_s = 1 / std::atof(argv[5]);
  const auto link = dds::openCycloneLink(options);
  for (int i = 0; i < 1000 && link->listeners() == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::uint64_t session = std::random_device()();
  for (int i = 0; i < reports; ++i) {
    team::PeerReport r = test::reportOnALine(static_cast<std::uint32_t>(options.robot), i);
    r.session = session;
    if (fault == "nan") r.T_W_B.p.z() = std::nan("");
    if (fault == "covariance") r.covariance(1, 1) = -1;
    if (fault == "version") r.version = 9;
    if (fault == "clock") r.t += 3600'000'000'000;
    if (fault == "reordered") r = test::reportOnALine(r.robot, i ^ 1), r.session = session;
    const int times = fault == "duplicated" ? 2 : 1;
    for (int k = 0; k < times; ++k) link->send(r);
    std::this_thread::sleep_for(std::chrono::duration<double>(period_s));
  }
  // Until the others have it all.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  return 0;
}
