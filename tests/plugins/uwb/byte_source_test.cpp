/// Serial port (a pseudo-terminal), TCP and UDP: bytes in order, and going on after an
/// interruption.
#include "byte_source.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>

#include "byte_fd.h"
#include "vir_test_pty.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

ByteSourceOptions optionsFor(const std::string& port) {
  ByteSourceOptions o;
  o.port = port;
  o.first_retry_s = 0.02;
  o.last_retry_s = 0.05;
  return o;
}

/// Reads until `size` bytes are there; the bound only ends a test that fails.
std::string readBytes(ByteSource* source, std::size_t size) {
  std::string text;
  std::uint8_t buffer[64];
  for (int i = 0; i < 500 && text.size() < size; ++i) {
    const std::size_t n = source->read(buffer, sizeof buffer, 20);
    text.append(reinterpret_cast<const char*>(buffer), n);
  }
  return text;
}

void readUntil(ByteSource* source, const std::function<bool()>& done) {
  std::uint8_t buffer[64];
  for (int i = 0; i < 500 && !done(); ++i) source->read(buffer, sizeof buffer, 20);
}

/// Sends `text` as a datagram from `from` to `port` of this machine's `to`.
void sendDatagram(const std::string& from, const std::string& to, int port,
                  const std::string& text) {
  const ByteFd sender(::socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in at{};
  at.sin_family = AF_INET;
  inet_pton(AF_INET, from.c_str(), &at.sin_addr);
  ASSERT_EQ(::bind(sender.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, to.c_str(), &at.sin_addr);
  ::sendto(sender.get(), text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&at), sizeof at);
}

/// Another address of this machine stands for another interface.
TEST(ByteSource, UdpWithoutAnAddressHearsOneInterfaceOnly) {
  const int port = 20000 + ::getpid() % 4000;
  ByteSource source(optionsFor("udp://:" + std::to_string(port)));
  source.open();
  sendDatagram("127.0.0.1", "127.0.0.2", port, "stranger");
  sendDatagram("127.0.0.1", "127.0.0.1", port, "friend");
  EXPECT_EQ(readBytes(&source, 6), "friend");
}

TEST(ByteSource, UdpFromOneHostOnly) {
  const int port = 20000 + ::getpid() % 4000;
  ByteSource source(optionsFor("udp://0.0.0.0:" + std::to_string(port) + "?from=127.0.0.3"));
  source.open();
  sendDatagram("127.0.0.1", "127.0.0.1", port, "stranger");
  sendDatagram("127.0.0.3", "127.0.0.1", port, "friend");
  EXPECT_EQ(readBytes(&source, 6), "friend");
  EXPECT_THROW(ByteSource(optionsFor("udp://:9?from=no.such.host.invalid")), DeviceError);
}

TEST(ByteSource, SerialPortUnpluggedAndBack) {
  const test::TempFolder folder;
  test::Pty pty(folder / "tty");
  ByteSource source(optionsFor(pty.path()));
  source.open();
  pty.send("hello");
  EXPECT_EQ(readBytes(&source, 5), "hello");
  EXPECT_TRUE(source.write("lec\r"));
  EXPECT_EQ(pty.received(), "lec\r");

  pty.pullOut();
  readUntil(&source, [&] { return source.state() == ByteSource::State::gone; });
  EXPECT_EQ(source.state(), ByteSource::State::gone);
  EXPECT_FALSE(source.write("x"));
  EXPECT_EQ(source.takeEvents().size(), 1u);
  for (int i = 0; i < 10; ++i) readUntil(&source, [&] { return true; });
  EXPECT_TRUE(source.takeEvents().empty());  // said once only

  pty.plugIn();
  readUntil(&source, [&] { return source.state() == ByteSource::State::open; });
  ASSERT_EQ(source.state(), ByteSource::State::open);
  EXPECT_EQ(source.reopened(), 1);
  pty.send("again");
  EXPECT_EQ(readBytes(&source, 5), "again");
  EXPECT_EQ(source.takeEvents().size(), 1u);
}

TEST(ByteSource, SerialPortTakesHighRatesOnly) {
  const test::TempFolder folder;
  test::Pty pty(folder / "tty");
  for (int baud : {9600, 115200, 921600}) {
    ByteSourceOptions o = optionsFor(pty.path());
    o.baud = baud;
    EXPECT_NO_THROW(ByteSource(o).open()) << baud;
  }
  ByteSourceOptions o = optionsFor(pty.path());
  o.baud = 123456;
  EXPECT_THROW(ByteSource source(o), DeviceError);
}

TEST(ByteSource, WhatIsNoDeviceIsRefused) {
  const test::TempFolder folder;
  test::writeText(folder / "file", "text");
  EXPECT_THROW(ByteSource(optionsFor((folder / "file").string())).open(), DeviceError);
  EXPECT_THROW(ByteSource(optionsFor((folder / "nothing").string())).open(), DeviceError);
  for (const char* port : {"", "tcp://", "tcp://host", "tcp://host:99999", "tcp://:80", "udp://:x",
                           "http://host:80"}) {
    EXPECT_THROW(ByteSource source(optionsFor(port)), DeviceError) << port;
  }
}

TEST(ByteSource, OnePortOneReader) {
  const test::TempFolder folder;
  test::Pty pty(folder / "tty");
  ByteSource first(optionsFor(pty.path())), second(optionsFor(pty.path()));
  first.open();
  EXPECT_THROW(second.open(), DeviceError);
  first.close();
  EXPECT_NO_THROW(second.open());
}

struct Server {
  Server() : listener(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof a;
    ::bind(listener.get(), reinterpret_cast<sockaddr*>(&a), size);
    ::listen(listener.get(), 4);
    ::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&a), &size);
    port = ntohs(a.sin_port);
  }
  void accept() { peer = ByteFd(::accept(listener.get(), nullptr, nullptr)); }
  ByteFd listener, peer;
  int port = 0;
};

TEST(ByteSource, TcpBrokenAndBack) {
  Server server;
  ByteSource source(optionsFor("tcp://127.0.0.1:" + std::to_string(server.port)));
  source.open();
  server.accept();
  ASSERT_EQ(::send(server.peer.get(), "abc", 3, 0), 3);
  EXPECT_EQ(readBytes(&source, 3), "abc");
  EXPECT_TRUE(source.write("x"));

  { const ByteFd closed = std::move(server.peer); }
  readUntil(&source, [&] { return source.reopened() == 1; });
  ASSERT_EQ(source.reopened(), 1);
  server.accept();
  ASSERT_EQ(::send(server.peer.get(), "def", 3, 0), 3);
  EXPECT_EQ(readBytes(&source, 3), "def");
}

TEST(ByteSource, NobodyListens) {
  int port = 0;
  { port = Server().port; }
  ByteSource source(optionsFor("tcp://127.0.0.1:" + std::to_string(port)));
  EXPECT_THROW(source.open(), DeviceError);
}

TEST(ByteSource, UdpInPiecesAndAnswers) {
  int port = 0;
  { port = Server().port; }  // free a moment ago
  ByteSource source(optionsFor("udp://127.0.0.1:" + std::to_string(port)));
  source.open();
  EXPECT_FALSE(source.write("nobody there yet"));
  const ByteFd sender(::socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const std::string text(200, 'u');  // more than the reader takes at once
  ASSERT_EQ(::sendto(sender.get(), text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&to),
                     sizeof to),
            200);
  EXPECT_EQ(readBytes(&source, 200), text);
  EXPECT_TRUE(source.write("answer"));
  char answer[16];
  EXPECT_EQ(::recv(sender.get(), answer, sizeof answer, 0), 6);
}

}  // namespace
}  // namespace vir
