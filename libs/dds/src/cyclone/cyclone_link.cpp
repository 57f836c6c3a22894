/// The team's link over Cyclone DDS.
#include "cyclone/cyclone_link.h"

#include <atomic>

#include "cyclone/domain.h"
#include "cyclone/report_sample.h"

namespace vir::dds {
namespace {

constexpr const char* kTopic = "vir_team_report";
constexpr std::int32_t kWriterKeeps = 64, kReaderKeeps = 256;  // reports
constexpr dds_duration_t kUseful = DDS_SECS(2);                // older, nobody waits for it
constexpr int kRounds = 8;                                     // of kAtOnce samples per take()
constexpr std::size_t kAtOnce = 64;

/// Both ends say the same but for how much they keep.
Qos reportQos(std::int32_t keeps) {
  Qos qos = newQos();
  // What the network loses is sent again; a robot that does not listen holds up nobody.
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, keeps);
  dds_qset_destination_order(qos.get(), DDS_DESTINATIONORDER_BY_RECEPTION_TIMESTAMP);
  return qos;
}

class CycloneLink final : public Link {
 public:
  CycloneLink(const LinkOptions& o, const LogSink& log) : domain_(Domain::of(o, log)) {
    const dds_entity_t p = domain_->participant();
    topic_ = Entity(dds_create_topic(p, &vir_team_Report_desc, kTopic, nullptr, nullptr), "topic");
    const Qos group = newQos();
    if (!o.team.empty()) dds_qset_partition1(group.get(), o.team.c_str());
    publisher_ = Entity(dds_create_publisher(p, group.get(), nullptr), "publisher");
    subscriber_ = Entity(dds_create_subscriber(p, group.get(), nullptr), "subscriber");
    const Qos out = reportQos(kWriterKeeps), in = reportQos(kReaderKeeps);
    dds_qset_lifespan(out.get(), kUseful);
    // What this program tells is not for itself.
    dds_qset_ignorelocal(out.get(), DDS_IGNORELOCAL_PARTICIPANT);
    dds_qset_ignorelocal(in.get(), DDS_IGNORELOCAL_PARTICIPANT);
    writer_ =
        checked(dds_create_writer(publisher_.get(), topic_.get(), out.get(), nullptr), "writer");
    reader_ =
        checked(dds_create_reader(subscriber_.get(), topic_.get(), in.get(), nullptr), "reader");
  }

  bool send(const team::PeerReport& report) override {
    const ReportSample sample(report);
    const bool sent = dds_write(writer_, &sample.sample()) == DDS_RETCODE_OK;
    ++(sent ? sent_ : not_sent_);
    return sent;
  }

  std::vector<team::PeerReport> take() override {
    std::vector<team::PeerReport> out;
    for (int round = 0; round < kRounds; ++round) {
      void* samples[kAtOnce] = {nullptr};
      dds_sample_info_t infos[kAtOnce];
      const dds_return_t n = dds_take(reader_, samples, infos, kAtOnce, kAtOnce);
      for (dds_return_t i = 0; i < n; ++i) {
        // The others say that a robot has gone.
        if (infos[i].valid_data) {
          out.push_back(reportOf(*static_cast<const vir_team_Report*>(samples[i])));
        }
      }
      if (n > 0) dds_return_loan(reader_, samples, n);
      if (n < static_cast<dds_return_t>(kAtOnce)) break;
    }
    received_ += static_cast<long>(out.size());
    return out;
  }

  int listeners() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_, &status);
    return static_cast<int>(status.current_count);
  }

  std::vector<std::pair<std::string, long>> counters() const override {
    dds_sample_lost_status_t lost{};
    dds_get_sample_lost_status(reader_, &lost);
    dds_requested_incompatible_qos_status_t other{};
    dds_get_requested_incompatible_qos_status(reader_, &other);
    return {{"sent", sent_},
            {"not_sent", not_sent_},
            {"received", received_},
            {"lost_on_the_way", static_cast<long>(lost.total_count)},
            {"other_quality", static_cast<long>(other.total_count)}};
  }

 private:
  std::shared_ptr<Domain> domain_;
  Entity topic_, publisher_, subscriber_;  // with what is in them
  dds_entity_t writer_ = 0, reader_ = 0;
  std::atomic<long> sent_{0}, not_sent_{0}, received_{0};
};

}  // namespace
std::unique_ptr<Link> openCycloneLink(const LinkOptions& options, const LogSink& log) {
  return std::make_unique<CycloneLink>(options, log);
}

}  // namespace vir::dds
