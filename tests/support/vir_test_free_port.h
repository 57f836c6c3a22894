#pragma once
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace vir::test {

/// A port of this machine that nobody listens at.
inline int freePort() {
  const int handle = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  EXPECT_EQ(bind(handle, reinterpret_cast<sockaddr*>(&at), size), 0);
  EXPECT_EQ(getsockname(handle, reinterpret_cast<sockaddr*>(&at), &size), 0);
  close(handle);
  return ntohs(at.sin_port);
}

}  // namespace vir::test
