/// A bad network between two teams: what one of them says is told to the other, in part, late, in
/// another order and twice. Ends when it is killed, or after five minutes.
///   vir_test_dds_relay DOMAIN TEAM TEAM LOST_SHARE LONGEST_DELAY_S TWICE_SHARE
#include <chrono>
#include <cstdlib>
#include <map>
#include <random>

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

  void carry(const End& from, const End& to) {
    void* samples[64] = {nullptr};
    dds_sample_info_t infos[64];
    const dds_return_t n = dds_take(from.reader, samples, infos, 64, 64);
    for (dds_return_t i = 0; i < n; ++i) {
      if (!infos[i].valid_data || uniform_(random_) < lost_) continue;
      const team::PeerReport r = dds::reportOf(*static_cast<vir_team_Report*>(samples[i]));
      for (int k = uniform_(random_) < twice_ ? 2 : 1; k > 0; --k) {
        const std::chrono::duration<double> delay(delay_s_ * uniform_(random_));
        due_.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(delay),
                     std::pair{to.writer, r});
      }
    }
    if (n > 0) dds_return_loan(from.reader, samples, n);
  }
  void deliver() {
    while (!due_.empty() && due_.begin()->first <= Clock::now()) {
      const auto& [writer, report] = due_.begin()->second;
      dds_write(writer, &dds::ReportSample(report).sample());
      due_.erase(due_.begin());
    }
  }

 private:
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
  const End a(participant, topic, argv[2]), b(participant, topic, argv[3]);
  if (a.writer < 0 || b.writer < 0 || a.reader < 0 || b.reader < 0) return 1;
  Relay relay(std::atof(argv[4]), std::atof(argv[5]), std::atof(argv[6]));
  const auto end = Clock::now() + std::chrono::minutes(5);
  while (Clock::now() < end) {
    relay.carry(a, b);
    relay.carry(b, a);
    relay.deliver();
    dds_sleepfor(DDS_MSECS(5));
  }
  return 0;
}
