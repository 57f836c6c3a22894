/// A program on the domain that says something else on the team's topic.
///   vir_test_dds_stranger DOMAIN TEAM
#include "stranger.h"

#include <dds/dds.h>

#include <cstdlib>

#include "vir/dds/link.h"

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  vir::dds::LinkOptions options;
  const auto domain = static_cast<dds_domainid_t>(std::atoi(argv[1]));
  if (dds_create_domain(domain, vir::dds::domainConfig(options).c_str()) < 0) return 1;
  const dds_entity_t p = dds_create_participant(domain, nullptr, nullptr);
  const dds_entity_t topic =
      dds_create_topic(p, &vir_team_Report_desc, "vir_team_report", nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_partition1(qos, argv[2]);
  const dds_entity_t publisher = dds_create_publisher(p, qos, nullptr);
  const dds_entity_t writer = dds_create_writer(publisher, topic, nullptr, nullptr);
  dds_delete_qos(qos);
  if (writer < 0) return 1;
  char text[] = "hello";
  vir_team_Report sample{1, text};
  for (int i = 0; i < 200; ++i) {
    if (dds_write(writer, &sample) < 0) return 1;
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_delete(p);
  return 0;
}
