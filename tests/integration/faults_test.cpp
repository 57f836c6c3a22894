/// What becomes of each command when it is killed or asked to end, the disk is full, the folder is
/// read-only, the input vanishes, memory ends, the clock is set or a device is unplugged: the table
/// of docs/faults.md, row by row. The faults come one after the other into the same output, so that
/// each has to do with what the one before left; then the command has to work.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <set>
#include <thread>

#include "faults_commands.h"
#include "faults_table.h"
#include "vir_test_clock.h"
#include "vir_test_process.h"
#include "vir_test_whole_files.h"

namespace vir {
namespace {

using test::contains;
using test::Limits;
using test::Process;
using test::quoted;
namespace fs = std::filesystem;

void pause(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

/// Whether a file was written to after `t`.
bool writtenTo(const fs::path& folder, fs::file_time_type t) {
  std::error_code gone;  // files come and go while this looks
  for (fs::recursive_directory_iterator it(folder, gone), end; !gone && it != end;
       it.increment(gone)) {
    if (it->is_regular_file(gone) && it->last_write_time(gone) > t && !gone) return true;
  }
  return false;
}

/// Waits until the process writes something. Returns false if it ended before that was seen.
bool begun(Process* p, const fs::path& folder, fs::file_time_type start) {
  for (int i = 0; i < 30000 && p->running() && !writtenTo(folder, start); ++i) pause(0.002);
  if (!p->running()) std::printf("ended before it was disturbed\n");
  return p->running();
}

/// Whether a process has `text` among its arguments.
bool anybodyWorksOn(const std::string& text) {
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc", gone)) {
    std::ifstream in(entry.path() / "cmdline", std::ios::binary);
    const std::string line((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (line.find(text) != std::string::npos) return true;
  }
  return false;
}

/// Faults that need a good moment: a busy or a very fast machine may not let them have it.
bool catchesAtWork() { return std::getenv("VIR_FAULT_TESTS") != nullptr; }

/// Limits are minded by the program, not by a sanitizer, which also has to be loaded first.
#ifdef VIR_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

class Faults : public testing::TestWithParam<const char*> {
 public:
  void killed(int code) {
    Process p(arguments());
    const bool in_time = begun(&p);
    p.send(SIGKILL);
    const int ended = p.wait();
    if (in_time) {
      EXPECT_EQ(ended, code) << p.text();
    }
    // A recording has its name from the start, before there is anything in it.
    for (const auto& file : fs::directory_iterator(out())) {
      const bool rawlog = command_.name == "record" && file.path().extension() == ".rawlog";
      if (rawlog && file.file_size() == 0) fs::remove(file.path());
    }
    // What it had started ends with it: it would write beside the next one.
    for (int i = 0; i < 1000 && anybodyWorksOn(out()); ++i) pause(0.01);
    EXPECT_FALSE(anybodyWorksOn(out()));
  }

  void terminated(int code) { askedToEnd(SIGTERM, code); }
  void interrupted(int code) { askedToEnd(SIGINT, code); }

  void diskFull(int code) {
    for (const long bytes : {0L, 20000L}) {
      Limits limits;
      limits.file_bytes = bytes;
      Process p(arguments(), limits);
      EXPECT_EQ(p.wait(), code) << p.text();
      EXPECT_TRUE(contains(p.text(), "too large") || contains(p.text(), "disk full") ||
                  contains(p.text(), "cannot write") || contains(p.text(), "failed"))
          << p.text();
      expectNoTrace(p.text());
      expectNoHalfFiles();
    }
  }

  void readOnly(int code) {
    const fs::path closed = folder_ / "closed";
    fs::create_directories(closed);
    fs::permissions(closed, fs::perms::owner_read | fs::perms::owner_exec);
    Limits limits;
    limits.mind_rights = true;
    Process p(command_.arguments(closed.string()), limits);
    EXPECT_EQ(p.wait(), code) << p.text();
    expectNoTrace(p.text());
    EXPECT_TRUE(contains(p.text(), "closed")) << p.text();
    EXPECT_TRUE(contains(p.text(), "ermission denied")) << p.text();
    fs::permissions(closed, fs::perms::owner_all);
    EXPECT_TRUE(fs::is_empty(closed));
  }

  void inputVanishes(int code) {
    ASSERT_TRUE(command_.take_input) << "the table has an input that the test does not know";
    Process p(arguments());
    const bool in_time = begun(&p);
    p.send(SIGSTOP);
    command_.take_input();
    p.send(SIGCONT);
    const int ended = p.wait();
    command_.give_input();
    expectNoTrace(p.text());
    if (!in_time) return;
    EXPECT_EQ(ended, code) << p.text();
    EXPECT_TRUE(contains(p.text(), "cut off") || contains(p.text(), "damaged") ||
                contains(p.text(), "missing") || contains(p.text(), "no such file") ||
                contains(p.text(), "failed: exit code"))
        << p.text();
  }

  void outOfMemory(int code) {
    if (kSanitized) return;
    startedWithLittleMemory();
    Process p(arguments());
    const bool in_time = begun(&p);
    p.giveNoMoreMemory();
    const int ended = p.wait();
    expectNoTrace(p.text());
    if (!in_time) return;
    // What it has may do for the rest.
    const bool enough = ended == 0;
    EXPECT_EQ(ended, enough ? 0 : code) << p.text();
    if (enough) std::printf("had all the memory it needed\n");
    EXPECT_FALSE(p.text().empty());
  }

  void clockIsSet(int code) {
    if (kSanitized) return;
    test::SettableClock clock((folder_ / "clock").string());
    Limits limits;
    limits.clock = clock.file();
    Process p(arguments(), limits);
    begun(&p);
    clock.setBy(-3600);
    EXPECT_EQ(p.wait(), code) << p.text();
  }

  /// A device that is pulled out, put in again, and is gone for good in the end.
  void deviceIsUnplugged(int code) {
    const std::string port = (folder_ / "imu").string(), sent = (folder_ / "sent.json").string();
    test::writeText(folder_ / "device.ini",
                    "[Recording]\nrawlog-grabber-ignore = true\n[device]\ndriver = SerialImu\n"
                    "process_rate = 500\nprotocol = text\nport = " +
                        port + "\n");
    const test::Outcome outcome = test::shell(
        quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
        quoted(faultInputs().at("w_A.rawlog")) + " --imu text=" + port +
        " --speed 3 --unplug-every 3 --unplug-for 1 --linger 0 --summary " + quoted(sent) +
        " > /dev/null & for i in $(seq 200); do [ -e " + port + " ] && break; sleep 0.05; done; " +
        quoted(test::buildDir() + "/bin/vir-slam") + " record " +
        quoted((folder_ / "device.ini").string()) + " --duration-s 5 --out " +
        quoted(out() + "/device.rawlog") + "; code=$?; wait; exit $code");
    EXPECT_EQ(outcome.code, code) << outcome.text;
    const auto counts = nlohmann::json::parse(test::readText(sent))["imu"];
    EXPECT_GE(counts["unplugs"].get<long>(), 1);
    EXPECT_TRUE(contains(outcome.text, "the device is gone")) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, "open again")) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, "  waiting")) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, " 0 lost")) << outcome.text;
  }

  /// The second one does not touch what the first one writes.
  void twoAtATime(int code) {
    const std::vector<std::string> same = arguments();
    Process first(same);
    if (!begun(&first)) return;
    first.send(SIGSTOP);  // it must not be done before the second one has looked
    Process second(same);
    EXPECT_EQ(second.wait(), code) << second.text();
    first.send(SIGCONT);
    EXPECT_TRUE(contains(second.text(), "another process is writing") ||
                contains(second.text(), "exists already"))
        << second.text();
    EXPECT_EQ(first.wait(), 0) << first.text();
  }

 protected:
  void SetUp() override {
    ASSERT_EQ(faultInputs().made().code, 0) << faultInputs().made().text;
    fs::create_directories(folder_ / "out");
    for (const FaultCommand& c : faultCommands()) {
      if (c.name == GetParam()) command_ = c;
    }
    ASSERT_EQ(command_.name, GetParam());
  }

  std::string out() const { return (folder_ / "out").string(); }
  /// Of the command; what it writes from now on is its sign of life.
  std::vector<std::string> arguments() {
    start_ = fs::file_time_type::clock::now();
    return command_.arguments(out());
  }
  bool begun(Process* p) const { return vir::begun(p, folder_ / "out", start_); }

  void expectNoHalfFiles() const { EXPECT_EQ(test::halfFiles(folder_ / "out"), ""); }
  static void expectNoTrace(const std::string& text) {
    EXPECT_FALSE(contains(text, "backtrace")) << text;
    EXPECT_FALSE(contains(text, "==== MRPT")) << text;
  }

  void askedToEnd(int signal, int code) {
    Process p(arguments());
    const bool in_time = begun(&p);
    pause(0.02);
    p.send(signal);
    const int ended = p.wait();
    EXPECT_EQ(fs::exists(folder_ / "out/r/summary.json"), command_.results_when_asked);
    if (!in_time) return;
    EXPECT_EQ(ended, code) << p.text();
    EXPECT_TRUE(contains(p.text(), command_.said_when_asked)) << p.text();
  }

  /// Address space in which the program just starts [MB].
  static long leastMemory() {
    static const long least = [] {
      long no = 0, yes = 4096;
      while (yes - no > 8) {
        Limits limits;
        limits.memory_mb = (no + yes) / 2;
        Process p({"--version"}, limits);
        (p.wait() == 0 ? yes : no) = limits.memory_mb;
      }
      return yes;
    }();
    return least;
  }

  /// With little memory from the start a command works (0) or says that it cannot: its plugins do
  /// not load (2), the work does not fit (1), not even the libraries do (127). Which of them is not
  /// for the test to say: it depends on where the system maps each library and on which allocation
  /// is the first that fails, and differs between versions of MRPT and OpenCV and from run to run.
  void startedWithLittleMemory() {
    for (const long more : {2L, 24L}) {
      Limits limits;
      limits.memory_mb = leastMemory() + more;
      Process p(arguments(), limits);
      const int code = p.wait();
      EXPECT_EQ(std::set<int>({0, 1, 2, 127}).count(code), 1u) << code << p.text();
      const bool enough = code == 0;
      EXPECT_TRUE(enough || !p.text().empty());
      expectNoTrace(p.text());
      expectNoHalfFiles();
    }
  }

  test::TempFolder folder_;
  FaultCommand command_;
  fs::file_time_type start_;
};

struct Fault {
  const char* row;
  void (Faults::*happens)(int code);
  bool at_work;  ///< the command has to be caught while it works
};

constexpr Fault kFaults[] = {
    {"folder read-only", &Faults::readOnly, false},
    {"disk full", &Faults::diskFull, false},
    {"SIGKILL", &Faults::killed, true},
    {"SIGTERM", &Faults::terminated, true},
    {"SIGINT (Ctrl-C)", &Faults::interrupted, true},
    {"input cut off, or it vanishes", &Faults::inputVanishes, true},
    {"out of memory", &Faults::outOfMemory, true},
    {"the clock is set back by an hour", &Faults::clockIsSet, false},
    {"the device is unplugged", &Faults::deviceIsUnplugged, false},
    {"a second one with the same `--out`", &Faults::twoAtATime, true},
};

TEST_P(Faults, EachHasItsOutcomeAndTheCommandWorksAfterwards) {
  for (const FaultRow& row : faultTable()) {
    const Fault* fault = nullptr;
    for (const Fault& f : kFaults) {
      if (row.fault == f.row) fault = &f;
    }
    ASSERT_NE(fault, nullptr) << "docs/faults.md has a fault without a test: " << row.fault;
    const std::string& cell = row.cells.at(command_.column);
    if (cell == "-" || (fault->at_work && !catchesAtWork())) continue;
    SCOPED_TRACE(row.fault);
    std::printf("%s: %s\n", row.fault.c_str(), cell.c_str());
    (this->*fault->happens)(exitCodeOf(cell));
    expectNoHalfFiles();
  }
  Process p(arguments());
  EXPECT_EQ(p.wait(), 0) << p.text();
  expectNoHalfFiles();
}

INSTANTIATE_TEST_SUITE_P(AllCommands, Faults,
                         testing::Values("simulate", "import", "run", "record", "batch",
                                         "rendezvous", "export_csv", "export_mcap"),
                         [](const auto& info) { return std::string(info.param); });

TEST(FaultsTable, SaysWhatBecomesOfEachCommandInEachFault) {
  const std::vector<FaultRow> rows = faultTable();
  ASSERT_EQ(rows.size(), std::size(kFaults));
  for (const Fault& fault : kFaults) {
    int times = 0;
    for (const FaultRow& row : rows) times += row.fault == fault.row ? 1 : 0;
    EXPECT_EQ(times, 1) << fault.row;
  }
  for (const FaultRow& row : rows) {
    EXPECT_EQ(row.cells.size(), 7u);
    for (const auto& [command, cell] : row.cells) {
      if (cell == "-") continue;
      EXPECT_NO_THROW(exitCodeOf(cell)) << row.fault << " of " << command;
    }
  }
}

}  // namespace
}  // namespace vir
