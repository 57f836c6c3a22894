/// `vir-slam-call ARGUMENTS`: as the program with these, by the one that is loaded already
/// (warm_program.cpp). Ends with its exit code, or by its signal.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "warm_socket.h"

namespace vir::test {
namespace {

int fail(const char* what) {
  std::fprintf(stderr, "vir-slam-call: %s: %s\n", what, std::strerror(errno));
  return 125;
}

std::string textOf(int argc, char** argv) {
  char folder[4096];
  if (getcwd(folder, sizeof folder) == nullptr) return {};
  std::string out = folder;
  const auto add = [&out](const std::string& text) { out += '\0' + text; };
  add(std::to_string(argc));
  add("vir-slam");
  for (int i = 1; i < argc; ++i) add(argv[i]);
  for (char** e = environ; *e != nullptr; ++e) {
    // Two reasons not to have it there: no call of a call, and no difference to a user's call.
    if (std::strncmp(*e, kWarmSocket, std::strlen(kWarmSocket)) != 0) add(*e);
  }
  return out + '\0';
}

bool sendCall(int socket, const std::string& text) {
  std::uint32_t size = static_cast<std::uint32_t>(text.size());
  const int streams[kStreams] = {0, 1, 2};
  iovec part{&size, sizeof size};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof streams)] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* head = CMSG_FIRSTHDR(&message);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof streams);
  std::memcpy(CMSG_DATA(head), streams, sizeof streams);
  return sendmsg(socket, &message, MSG_NOSIGNAL) == sizeof size &&
         sendAll(socket, text.data(), text.size());
}

int call(int argc, char** argv) {
  const char* name = std::getenv(kWarmSocket);
  if (name == nullptr) return fail(kWarmSocket);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  socklen_t size = 0;
  const sockaddr_un address = warmAddress(name, &size);
  if (socket < 0 || connect(socket, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    return fail("cannot reach the program");
  }
  int status = 0;
  if (!sendCall(socket, textOf(argc, argv)) ||
      !receiveAll(socket, reinterpret_cast<char*>(&status), sizeof status)) {
    return fail("the program has gone");
  }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  // As the shell sees a program that a signal ended.
  return 128 + WTERMSIG(status);
}

}  // namespace
}  // namespace vir::test

int main(int argc, char** argv) { return vir::test::call(argc, argv); }
