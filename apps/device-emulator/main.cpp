/// vir-device-emulator: plays the ranges and inertial readings of a rawlog out on pseudo-terminals,
/// as the devices would send them.
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <thread>

#include "emulated_device.h"
#include "recording.h"
#include "vir/core/resource_usage.h"

namespace {

using namespace vir;
using namespace vir::emulator;

volatile std::sig_atomic_t stop_asked = 0;

struct Arguments {
  std::string rawlog, uwb, imu, summary;
  RecordingLabels labels;
  DeviceOptions device;
  double speed = 1, wait_s = 60, linger_s = 1;
  int repeat = 1;
  bool no_wait = false;
  double start_at_s = 0;
};

/// "PROTOCOL" or "PROTOCOL=LINK".
DeviceOptions deviceOptions(const Arguments& a, const std::string& text) {
  DeviceOptions o = a.device;
  const std::size_t equals = text.find('=');
  o.protocol = text.substr(0, equals);
  if (equals != std::string::npos) o.link = text.substr(equals + 1);
  return o;
}

class Emulator {
 public:
  explicit Emulator(const Arguments& a) : arguments_(a) {
    if (!a.uwb.empty()) radio_ = std::make_unique<EmulatedRadio>(deviceOptions(a, a.uwb));
    if (!a.imu.empty()) {
      DeviceOptions o = deviceOptions(a, a.imu);
      o.shell = false;
      o.air = {};
      imu_ = std::make_unique<EmulatedImu>(o);
    }
    for (EmulatedDevice* d :
         {static_cast<EmulatedDevice*>(radio_.get()), static_cast<EmulatedDevice*>(imu_.get())}) {
      if (d != nullptr) devices_.push_back(d);
    }
  }

  /// False if no reader came in time.
  bool run(const std::vector<Event>& events) {
    for (EmulatedDevice* d : devices_) {
      d->plugIn();
      std::printf("%s: %s (%s)\n", d->options().protocol.c_str(), d->port().path().c_str(),
                  d->port().name().c_str());
    }
    std::fflush(stdout);
    if (!arguments_.no_wait && !waitForReaders()) return false;
    start_s_ = wallSeconds();
    if (arguments_.start_at_s > 0) {
      const auto host = std::chrono::system_clock::now().time_since_epoch();
      start_s_ += arguments_.start_at_s - std::chrono::duration<double>(host).count();
    }
    TimeNs offset = 0;
    for (int i = 0; i < arguments_.repeat && stop_asked == 0; ++i) {
      for (const Event& e : events) {
        sleepUntil(offset + e.t);
        if (stop_asked != 0) break;
        play(offset + e.t, e);
      }
      offset += events.back().t + events.back().t / static_cast<TimeNs>(events.size());
    }
    const double end = wallSeconds() + arguments_.linger_s;
    while (wallSeconds() < end) serviceAll(0.002);
    return true;
  }

  std::string summary() const {
    std::string text = "{";
    for (const EmulatedDevice* d : devices_) {
      const DeviceCounts& c = d->counts();
      char line[512];
      std::snprintf(line, sizeof line,
                    "%s\n  \"%s\": {\"protocol\": \"%s\", \"messages\": %ld, \"sent\": %ld, "
                    "\"damaged\": %ld, \"unheard\": %ld, \"unplugged\": %ld, \"refused\": %ld, "
                    "\"overrun\": %ld, \"garbage_bytes\": %ld, \"unplugs\": %ld}",
                    text.size() > 1 ? "," : "", d == radio_.get() ? "uwb" : "imu",
                    d->options().protocol.c_str(), c.messages, c.sent, c.damaged,
                    c.unheard + (d == radio_.get() ? radio_->unasked() : 0), c.unplugged, c.refused,
                    c.overrun, c.garbage_bytes, c.unplugs);
      text += line;
    }
    if (radio_ && !radio_->options().air.folder.empty()) {
      text += ",\n  \"air\": {\"data_out\": " + std::to_string(radio_->dataOut()) +
              ", \"data_in\": " + std::to_string(radio_->dataIn()) + "}";
    }
    return text + "\n}\n";
  }

 private:
  bool waitForReaders() {
    const double give_up = wallSeconds() + arguments_.wait_s;
    while (wallSeconds() < give_up && stop_asked == 0) {
      bool all = true;
      for (EmulatedDevice* d : devices_) {
        d->service(0, wallSeconds());
        all &= d->heard(wallSeconds());
      }
      if (all) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  TimeNs now() const { return fromSeconds((wallSeconds() - start_s_) * arguments_.speed); }

  void serviceAll(double sleep_s) {
    std::this_thread::sleep_for(std::chrono::duration<double>(sleep_s));
    for (EmulatedDevice* d : devices_) d->service(now(), wallSeconds());
  }

  void sleepUntil(TimeNs t) {
    for (;;) {
      const double left_s = toSeconds(t - now()) / arguments_.speed;
      if (left_s <= 0 || stop_asked != 0) return;
      serviceAll(std::min(left_s, 0.005));
    }
  }

  void play(TimeNs t, const Event& e) {
    const double now_s = wallSeconds();
    if (const auto* range = std::get_if<RangeItem>(&e.what)) {
      if (radio_) radio_->play(t, *range, now_s);
    } else if (imu_) {
      imu_->play(t, std::get<ImuMessage>(e.what), now_s);
    }
  }

  Arguments arguments_;
  std::unique_ptr<EmulatedRadio> radio_;
  std::unique_ptr<EmulatedImu> imu_;
  std::vector<EmulatedDevice*> devices_;
  double start_s_ = 0;
};

void declare(CLI::App* app, Arguments* a) {
  app->description(
      "Plays the ranges and inertial readings of a rawlog out on pseudo-terminals, as devices "
      "would "
      "send them\nExamples:\n"
      "  vir-device-emulator flight.rawlog --uwb dwm1001 --imu text\n"
      "  vir-device-emulator flight.rawlog --uwb nlink=/tmp/uwb --imu mavlink=/tmp/imu --speed 2\n"
      "  vir-device-emulator flight.rawlog --uwb dwm1001=/tmp/uwb --shell --unplug-every 10");
  app->add_option("RAWLOG", a->rawlog, "Recording to play")->required();
  app->add_option("--uwb", a->uwb,
                  "PROTOCOL[=LINK] of the radio (dwm1001, dwm1001_tlv, trek1000, at_range, qm33, "
                  "nlink, dw1000_arduino, json); LINK: symbolic link to make to the port");
  app->add_option("--imu", a->imu,
                  "PROTOCOL[=LINK] of the IMU (text, binary, mavlink, mavlink_scaled)");
  app->add_option("--range-labels", a->labels.ranges, "Labels of the ranges to play")
      ->capture_default_str();
  app->add_option("--imu-label", a->labels.imu, "Label of the readings to play")
      ->capture_default_str();
  app->add_option("--speed", a->speed, "Pace; 2 = twice as fast as recorded")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  app->add_option("--repeat", a->repeat, "Play it so many times")->check(CLI::Range(1, 1000000));
  app->add_flag("--no-wait", a->no_wait, "Start at once, not when every port has a reader");
  app->add_option(
      "--start-at", a->start_at_s,
      "When the first message is due [s since 1970], to be in step with another program");
  app->add_option("--wait", a->wait_s, "Give up when no reader comes for so many seconds")
      ->capture_default_str();
  app->add_option("--linger", a->linger_s, "Seconds that the ports stay after the last message")
      ->capture_default_str();
  app->add_option("--own-id", a->device.own_id, "Id of the radio (nlink)")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  app->add_option("--air", a->device.air.folder,
                  "Folder where emulated radios meet (nlink): what a program writes to one comes "
                  "out of the others");
  app->add_option("--air-lost", a->device.air.lost, "Share of it that is lost")
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--air-damaged", a->device.air.damaged, "Share of it that has a byte changed")
      ->check(CLI::Range(0.0, 1.0));
  app->add_flag("--shell", a->device.shell, "The radio is silent until told `lec` (DWM1001)");
  app->add_option("--clock-offset", a->device.clock_offset_s, "Device time at the start [s]");
  app->add_option("--clock-drift", a->device.clock_drift_ppm, "Device clock fast by [ppm]");
  FaultOptions& f = a->device.faults;
  app->add_option("--garbage", f.garbage, "Share of messages with random bytes before them")
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--corrupt", f.corrupt, "Share of messages with a byte changed")
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--unplug-every", f.unplug_every_s, "Pull the devices out after each so many s");
  app->add_option("--unplug-for", f.unplug_for_s, "... for so long")->capture_default_str();
  app->add_option("--seed", f.seed, "Of garbage and damage");
  app->add_option("--summary,--count", a->summary,
                  "Write what was sent as JSON to this file (it is printed in any case)");
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app;
  declare(&app, &a);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (a.uwb.empty() && a.imu.empty()) {
    std::fprintf(stderr, "vir-device-emulator: nothing to emulate: give --uwb, --imu or both\n");
    return 2;
  }
  const auto ask_to_stop = [](int) { stop_asked = 1; };
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::signal(SIGHUP, ask_to_stop);
  try {
    Emulator emulator(a);
    const bool heard = emulator.run(readRecording(a.rawlog, a.labels));
    const std::string summary = emulator.summary();
    std::fputs(summary.c_str(), stdout);
    if (!a.summary.empty() && !(std::ofstream(a.summary) << summary)) {
      throw std::runtime_error(a.summary + ": cannot be written");
    }
    if (!heard) throw std::runtime_error("no program opened the ports in time");
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "vir-device-emulator: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "vir-device-emulator: %s\n", e.what());
    return 1;
  }
  return 0;
}
