/// A bad network between teams: what one of them says is told to the others, in part, late, in
/// another order and twice. Ends when it is killed, or after ten minutes.
///   vir_test_dds_relay DOMAIN LOST_SHARE LONGEST_DELAY_S TWICE_SHARE TEAM TEAM...
#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "cyclone/dds_entities.h"
#include "cyclone/report_sample.h"
#include "vir/dds/link.h"

namespace {

using namespace vir;
using Clock = std::chrono::steady_clock;

/// One end: hears a team, and speaks to it.
struct End {
  dds_entity_t reader = 0, writer = 0;

  End(dds_entity_t participant, dds_entity_t topic, const char* team) {
    const dds::Qos group = dds::newQos(), qos = dds::newQos();
    dds_qset_partition1(group.get(), team);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 256);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    const dds_entity_t in = dds_create_subscriber(participant, group.get(), nullptr);
    const dds_entity_t out = dds_create_publisher(participant, group.get(), nullptr);
    reader = dds_create_reader(in, topic, qos.get(), nullptr);
    writer = dds_create_writer(out, topic, qos.get(), nullptr);
  }
};

class Relay {
 public:
  Relay(double lost, double delay_s, double twice)
      : lost_(lost), delay_s_(delay_s), twice_(twice) {}

  /// What `ends[from]` has heard, to all others.
  void carry(const std::vector<End>& ends, std::size_t from) {
    void* samples[64] = {nullptr};
    dds_sample_info_t infos[64];
    const dds_return_t n = dds_take(ends[from].reader, samples, infos, 64, 64);
    for (dds_return_t i = 0; i < n; ++i) {
      if (!infos[i].valid_data) continue;
      const team::PeerReport r = dds::reportOf(*static_cast<vir_team_Report*>(samples[i]));
      for (std::size_t to = 0; to < ends.size(); ++to) {
        if (to != from && uniform_(random_) >= lost_) send(ends[to].writer, r);
      }
    }
    if (n > 0) dds_return_loan(ends[from].reader, samples, n);
  }
  void deliver() {
    while (!due_.empty() && due_.begin()->first <= Clock::now()) {
      const auto& [writer, report] = due_.begin()->second;
      dds_write(writer, &dds::ReportSample(report).sample());
      due_.erase(due_.begin());
    }
  }

 private:
  void send(dds_entity_t writer, const team::PeerReport& r) {
    for (int k = uniform_(random_) < twice_ ? 2 : 1; k > 0; --k) {
      const std::chrono::duration<double> delay(delay_s_ * uniform_(random_));
      due_.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(delay),
                   std::pair{writer, r});
    }
  }
  double lost_, delay_s_, twice_;
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::multimap<Clock::time_point, std::pair<dds_entity_t, team::PeerReport>> due_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) return 2;
  const auto domain = static_cast<dds_domainid_t>(std::atoi(argv[1]));
  if (dds_create_domain(domain, dds::domainConfig({}).c_str()) < 0) return 1;
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  const dds_entity_t topic =
      dds_create_topic(participant, &vir_team_Report_desc, "vir_team_report", nullptr, nullptr);
  std::vector<End> ends;
  for (int i = 5; i < argc; ++i) {
    ends.emplace_back(participant, topic, argv[i]);
    if (ends.back().writer < 0 || ends.back().reader < 0) return 1;
  }
  Relay relay(std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4]));
  const auto end = Clock::now() + std::chrono::minutes(10);
  while (Clock::now() < end) {
    for (std::size_t i = 0; i < ends.size(); ++i) relay.carry(ends, i);
    relay.deliver();
    dds_sleepfor(DDS_MSECS(5));
  }
  return 0;
}
