#include <gtest/gtest.h>

#include <fstream>

#include "vir/core/settings.h"
#include "vir/dds/link.h"
#include "vir_test_temp_folder.h"

namespace vir::dds {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(DomainConfig, ByItselfIsForThisMachine) {
  const std::string xml = domainConfig({});
  EXPECT_TRUE(has(xml, "<NetworkInterface address=\"127.0.0.1\"/>")) << xml;
  EXPECT_TRUE(has(xml, "<AllowMulticast>false</AllowMulticast>"));
  EXPECT_TRUE(has(xml, "<Peer address=\"127.0.0.1\"/>"));
  LinkOptions o;
  EXPECT_EQ(o.robot, -1) << "off";
  o.multicast = true;
  EXPECT_EQ(domainConfig(o), xml) << "there is none on loopback";
}

TEST(DomainConfig, OfANetwork) {
  LinkOptions o;
  o.interface = "wlan0";
  o.multicast = true;
  o.peers = " 10.0.0.7  base ";
  const std::string xml = domainConfig(o);
  EXPECT_TRUE(has(xml, "<NetworkInterface name=\"wlan0\"/>")) << xml;
  EXPECT_TRUE(has(xml, "<AllowMulticast>true</AllowMulticast>"));
  EXPECT_TRUE(has(xml, "<Peers><Peer address=\"10.0.0.7\"/><Peer address=\"base\"/></Peers>"));
  EXPECT_FALSE(has(xml, "127.0.0.1"));
  o.interface = "10.0.0.3";
  EXPECT_TRUE(has(domainConfig(o), "<NetworkInterface address=\"10.0.0.3\"/>"));
  o.interface = "auto";
  EXPECT_FALSE(has(domainConfig(o), "NetworkInterface"));
  o.interface = "\"/><x";
  EXPECT_FALSE(has(domainConfig(o), "<x")) << "a name is no XML";
}

TEST(DomainConfig, OfAFile) {
  const test::TempFolder folder;
  const std::string file = (folder / "c.xml").string();
  std::ofstream(file) << "<CycloneDDS/>";
  LinkOptions o;
  o.config = file;
  EXPECT_EQ(domainConfig(o), "<CycloneDDS/>");
  o.config += "x";
  EXPECT_THROW(domainConfig(o), std::runtime_error);
}

}  // namespace
}  // namespace vir::dds
