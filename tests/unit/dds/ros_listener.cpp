/// Listens as a node of ROS 2 would, without any of our code: a line of JSON per message, and one
/// per writer that it finds. Ends when it is killed, or after two minutes.
///   vir_test_dds_ros_listener DOMAIN NAMESPACE
#include "ros_listener.h"

#include <dds/dds.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr const char* kConfig =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto"
    "</ParticipantIndex><MaxAutoParticipantIndex>40</MaxAutoParticipantIndex><Peers><Peer "
    "address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

dds_entity_t readerOf(dds_entity_t participant, const std::string& name,
                      const dds_topic_descriptor_t* type) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const dds_entity_t topic =
      dds_create_topic(participant, type, ("rt" + name).c_str(), nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  if (reader < 0) std::exit(1);
  return reader;
}

template <typename Message, typename Print>
void printAll(dds_entity_t reader, Print print) {
  void* samples[16] = {nullptr};
  dds_sample_info_t infos[16];
  const dds_return_t n = dds_take(reader, samples, infos, 16, 16);
  for (dds_return_t i = 0; i < n; ++i) {
    if (infos[i].valid_data) print(*static_cast<Message*>(samples[i]));
  }
  if (n > 0) dds_return_loan(reader, samples, n);
}

void printWriters(dds_entity_t reader) {
  printAll<dds_builtintopic_endpoint_t>(reader, [](const dds_builtintopic_endpoint_t& e) {
    void* data = nullptr;
    std::size_t size = 0;
    dds_qget_userdata(e.qos, &data, &size);
    std::printf("{\"writer\":\"%s\",\"type\":\"%s\",\"user_data\":\"%.*s\"}\n", e.topic_name,
                e.type_name, static_cast<int>(size), static_cast<const char*>(data));
    dds_free(data);
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const auto domain = static_cast<dds_domainid_t>(std::atoi(argv[1]));
  const std::string name = argv[2];
  if (dds_create_domain(domain, kConfig) < 0) return 1;
  const dds_entity_t p = dds_create_participant(domain, nullptr, nullptr);
  const dds_entity_t writers =
      dds_create_reader(p, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  const dds_entity_t odometry = readerOf(p, name + "/odometry", &nav_msgs_msg_dds__Odometry__desc);
  const dds_entity_t pose =
      readerOf(p, name + "/pose", &geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc);
  const dds_entity_t tf = readerOf(p, "/tf", &tf2_msgs_msg_dds__TFMessage__desc);
  std::printf("{\"ready\":true}\n");
  for (int i = 0; i < 12000; ++i) {
    printWriters(writers);
    printAll<nav_msgs_msg_dds__Odometry_>(odometry, [](const nav_msgs_msg_dds__Odometry_& m) {
      std::printf(
          "{\"topic\":\"odometry\",\"s\":%d,\"ns\":%u,\"frame\":\"%s\",\"child\":\"%s\","
          "\"p\":[%.9f,%.9f,%.9f],\"q\":[%.9f,%.9f,%.9f,%.9f],\"C\":[%.9g,%.9g,%.9g],"
          "\"v\":[%.9f,%.9f,%.9f]}\n",
          m.s, m.ns, m.frame, m.child, m.at.a, m.at.b, m.at.c, m.turn.a, m.turn.b, m.turn.c,
          m.turn.d, m.covariance[0], m.covariance[21], m.covariance[35], m.linear.a, m.linear.b,
          m.linear.c);
    });
    using PoseMessage = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;
    printAll<PoseMessage>(pose, [](const PoseMessage& m) {
      std::printf(
          "{\"topic\":\"pose\",\"s\":%d,\"ns\":%u,\"frame\":\"%s\",\"p\":[%.9f,%.9f,%.9f],"
          "\"C\":[%.9g,%.9g,%.9g]}\n",
          m.s, m.ns, m.frame, m.at.a, m.at.b, m.at.c, m.covariance[0], m.covariance[21],
          m.covariance[35]);
    });
    printAll<tf2_msgs_msg_dds__TFMessage_>(tf, [](const tf2_msgs_msg_dds__TFMessage_& m) {
      for (std::uint32_t k = 0; k < m.all._length; ++k) {
        const auto& t = m.all._buffer[k];
        std::printf(
            "{\"topic\":\"tf\",\"s\":%d,\"ns\":%u,\"frame\":\"%s\",\"child\":\"%s\","
            "\"p\":[%.9f,%.9f,%.9f]}\n",
            t.s, t.ns, t.frame, t.child, t.at.a, t.at.b, t.at.c);
      }
    });
    std::fflush(stdout);
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_delete(p);
  return 0;
}
