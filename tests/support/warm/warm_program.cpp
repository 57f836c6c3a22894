/// The program for tests that call it many times. Loading it takes a quarter of a second of CPU
/// time, as 170 libraries of MRPT's and OpenCV's come with it, and as much again where a sensor is
/// asked for; most calls of tests take less. Here it is loaded once, and every call is a process
/// forked off it that runs the program's main() with the caller's arguments, folder, environment
/// and streams. Called without `--listen` it is the program.
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "vir/roles/sensor.h"
#include "warm_socket.h"

// The linker gives the program's main() the first name and calls the second (--wrap=main).
extern "C" int __real_main(int argc, char** argv);
extern "C" int __wrap_main(int argc, char** argv);

namespace vir::test {
namespace {

struct Call {
  int streams[kStreams] = {-1, -1, -1};
  std::string folder;
  std::vector<std::string> arguments, environment;
};

/// The size of what follows, and with it the streams; then texts, each with a zero at its end:
/// folder, number of arguments, arguments, environment.
bool receive(int socket, Call* call) {
  std::uint32_t size = 0;
  iovec part{&size, sizeof size};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof call->streams)] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  if (recvmsg(socket, &message, MSG_CMSG_CLOEXEC) != sizeof size) return false;
  const cmsghdr* head = CMSG_FIRSTHDR(&message);
  if (head == nullptr || head->cmsg_len != CMSG_LEN(sizeof call->streams)) return false;
  std::memcpy(call->streams, CMSG_DATA(head), sizeof call->streams);
  std::vector<char> bytes(size);
  if (!receiveAll(socket, bytes.data(), size)) return false;
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += texts.back().size() + 1) {
    texts.emplace_back(&bytes[at]);
  }
  if (texts.size() < 2) return false;
  call->folder = texts[0];
  const auto first = texts.begin() + 2, behind = first + std::stol(texts[1]);
  call->arguments.assign(first, behind);
  call->environment.assign(behind, texts.end());
  return true;
}

[[noreturn]] void be(Call call) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (int i = 0; i < kStreams; ++i) dup2(call.streams[i], i);
  if (chdir(call.folder.c_str()) != 0) _exit(126);
  clearenv();
  for (std::string& text : call.environment) putenv(text.data());
  std::vector<char*> argv;
  for (std::string& text : call.arguments) argv.push_back(text.data());
  const int argc = static_cast<int>(argv.size());
  argv.push_back(nullptr);
  const int code = __real_main(argc, argv.data());
  // Without what all those libraries do at the end of a process: half of the cost of a call.
  std::fflush(nullptr);
  _exit(code);
}

/// Before the first call that asks for a sensor: else each of them would load MRPT's drivers.
void loadDriversFor(const Call& call) {
  static bool loaded = false;
  if (loaded) return;
  const auto names_one = [&](const char* command) {
    return std::find(call.arguments.begin(), call.arguments.end(), command) != call.arguments.end();
  };
  for (const char* command : {"import", "simulate", "record", "plugins", "check"}) {
    loaded = loaded || names_one(command);
  }
  if (loaded) roles::openMrptSensor("");
}

void serve(int socket) {
  Call call;
  if (!receive(socket, &call)) return;
  loadDriversFor(call);
  const pid_t child = fork();
  if (child == 0) be(std::move(call));
  for (const int stream : call.streams) close(stream);
  int status = 127 << 8;
  if (child > 0) {
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
  }
  sendAll(socket, reinterpret_cast<const char*>(&status), sizeof status);
}

int listenOn(int listening) {
  // Ends with the test.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (;;) {
    const int socket = accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EINTR) continue;
      return 1;
    }
    serve(socket);
    close(socket);
  }
}

}  // namespace
}  // namespace vir::test

int __wrap_main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--listen") {
    return vir::test::listenOn(std::atoi(argv[2]));
  }
  return __real_main(argc, argv);
}
