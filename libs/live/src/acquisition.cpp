#include "vir/live/acquisition.h"

#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "vir/core/device_clock.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/live_source.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor.h"
#include "vir/roles/sensor_section.h"

namespace vir::live {
namespace {

using SteadyClock = std::chrono::steady_clock;

mrpt::config::CConfigFileMemory configOf(const Settings& settings) {
  mrpt::config::CConfigFileMemory config;
  for (const Setting& s : settings.all()) config.write(s.section, s.key, s.value);
  return config;
}

/// One of ours by name or class, or one of MRPT's by class.
std::unique_ptr<roles::Sensor> makeSensor(const std::string& driver) {
  if (auto sensor = roles::openMrptSensor(driver)) return sensor;
  return roles::openSensor(driver);
}

SteadyClock::duration seconds(double s) {
  return std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

/// A sensor and its thread.
class Acquisition::Sensor {
 public:
  Sensor(Acquisition* owner, std::size_t index, const Settings& settings,
         const std::string& section, std::string image_folder)
      : owner_(owner),
        index_(index),
        section_(roles::readSensorSection(settings, section)),
        keeps_stamps_(section_.clock == "keep"),
        config_(configOf(settings)),
        image_folder_(std::move(image_folder)) {
    status_.name = section;
    status_.driver = section_.driver;
    try {
      device_ = create();  // wrong settings are found before anything is started
      wants_states_ = device_->live() != nullptr && device_->live()->wantsStates();
    } catch (const roles::PluginError&) {
      throw;
    } catch (const std::exception& e) {
      throw SettingsError({settings.name(), 0}, section, "", rawlog::shortReason(e));
    }
  }
  ~Sensor() { stop(); }
  Sensor(const Sensor&) = delete;
  Sensor& operator=(const Sensor&) = delete;

  /// Why it cannot be used; empty if it can.
  std::string initialize() {
    try {
      device_->initialize();
      return {};
    } catch (const std::exception& e) {
      device_.reset();
      return rawlog::shortReason(e);
    }
  }

  void launch(const std::string& problem) {
    if (!problem.empty()) fail(problem);
    thread_ = std::thread([this] { work(); });
  }

  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  bool optional() const { return section_.optional; }
  bool wantsStates() const { return wants_states_; }
  void tell(const StateEstimate& estimate, std::vector<Anchor> anchors) {
    const std::lock_guard<std::mutex> lock(mutex_);
    to_tell_.emplace(estimate, std::move(anchors));
  }
  bool ended() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return status_.state == SensorState::ended;
  }
  SensorStatus status() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return status_;
  }

 private:
  std::unique_ptr<roles::Sensor> create() const {
    std::unique_ptr<roles::Sensor> device = makeSensor(section_.driver);
    if (device->live() != nullptr) device->muteConsole();  // what it has to say comes by LiveSource
    if (!image_folder_.empty()) device->setPathForExternalImages(image_folder_);
    device->loadConfig(config_, section_.name);
    return device;
  }

  void work() {
    double pause = owner_->options_.first_retry_s;
    while (!stopped()) {
      const auto begun = SteadyClock::now();
      std::string problem;
      try {
        if (!device_) {
          sleepFor(pause);
          if (stopped()) return;
          device_ = create();
          device_->initialize();
          const std::lock_guard<std::mutex> lock(mutex_);
          ++status_.restarts;
        }
        if (play()) return setState(SensorState::ended);
      } catch (const std::exception& e) {
        problem = rawlog::shortReason(e);
      }
      if (stopped()) return;
      collect();
      device_.reset();
      fail(problem.empty() ? "its driver reports an error" : problem);
      const bool lasted = SteadyClock::now() - begun > seconds(2 * pause + 5);
      pause = lasted ? owner_->options_.first_retry_s
                     : std::min(2 * pause, owner_->options_.last_retry_s);
    }
  }

  /// Until it is stopped, fails (false) or has come to its end (true).
  bool play() {
    setState(SensorState::running);
    const roles::RecordedSource* source = device_->recorded();
    auto next = SteadyClock::now();
    const auto period = seconds(1 / section_.rate_hz);
    while (!stopped()) {
      device_->doProcess();
      collect();
      listen();
      if (source != nullptr && source->finished()) {
        for (const std::string& text : source->warnings()) warn(text);
        return true;
      }
      if (device_->failed()) return false;
      next = std::max(next + period, SteadyClock::now() - period);
      sleepUntil(next);
    }
    collect();
    counted_ = {};
    listen();
    return false;
  }

  /// What a live driver has to tell.
  void listen() {
    roles::LiveSource* live = device_->live();
    if (live == nullptr) return;
    if (const auto news = takeNews()) live->tell(news->first, news->second);
    const bool there = live->connected();
    for (const roles::SensorMessage& m : live->takeMessages()) say(m.level, m.text);
    if (there != connected_) setState(there ? SensorState::running : SensorState::waiting);
    connected_ = there;
    const auto now = SteadyClock::now();
    if (now - counted_ < std::chrono::seconds(1)) return;
    counted_ = now;
    auto counters = live->counters();
    const std::lock_guard<std::mutex> lock(mutex_);
    status_.counters = std::move(counters);
  }

  using News = std::pair<StateEstimate, std::vector<Anchor>>;
  std::optional<News> takeNews() {
    if (!wants_states_) return std::nullopt;
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(to_tell_, std::nullopt);
  }

  /// Hands over what the driver has.
  void collect() {
    if (!device_) return;
    std::vector<mrpt::obs::CObservation::Ptr> all;
    try {
      all = device_->takeObservations();
    } catch (const std::exception&) {
      return;  // a driver that failed may not even answer this
    }
    const TimeNs now = hostNow();
    std::vector<Arrival> arrivals;
    for (const mrpt::obs::CObservation::Ptr& observation : all) {
      putOnHostClock(observation.get(), now);  // both images of a pair alike
      for (const auto& [part, right] : apart(observation)) {
        prepare(part.get(), right);
        arrivals.push_back({index_, part, now});
      }
    }
    if (arrivals.empty()) return;
    if (auto note = owner_->clockNote(now)) arrivals.push_back({index_, note, now});
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      status_.observations += static_cast<long>(arrivals.size());
    }
    owner_->deliver(&arrivals);
  }

  /// What cannot be taken apart goes on as it is.
  std::vector<std::pair<mrpt::obs::CObservation::Ptr, bool>> apart(
      const mrpt::obs::CObservation::Ptr& observation) {
    try {
      return roles::takenApart(section_, observation);
    } catch (const std::exception& e) {
      if (!std::exchange(said_whole_, true)) {
        warn("an image cannot be taken apart: " + rawlog::shortReason(e));
      }
      return {{observation, false}};
    }
  }

  void prepare(mrpt::obs::CObservation* observation, bool right) {
    auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(observation);
    try {
      // From here on nobody changes it.
      if (image != nullptr && image->image.isExternallyStored()) image->image.forceLoad();
      roles::complete(section_, observation, right);
    } catch (const std::exception& e) {
      warn("an image cannot be read: " + rawlog::shortReason(e));
    }
  }

  void putOnHostClock(mrpt::obs::CObservation* observation, TimeNs now) {
    if (keeps_stamps_) return;
    TimeNs t = rawlog::fromMrptTime(observation->timestamp);
    // A driver that takes the wall clock for its stamps went along when that was set.
    const TimeNs step = hostClockStep();
    if (step != 0 && std::abs(t - step - now) < std::abs(t - now)) {
      t -= step;
      observation->timestamp = rawlog::toMrptTime(t);
    }
    if (!own_clock_) {
      own_clock_ =
          section_.clock == "device" || std::abs(t - now) > owner_->options_.own_clock_beyond;
      if (*own_clock_) {
        warn("its stamps are " + std::to_string(toSeconds(t - now)) +
             " s off the host's clock; they are put on it by their arrival");
        const std::lock_guard<std::mutex> lock(mutex_);
        status_.clock_mapped = true;
      }
    }
    if (!*own_clock_) return;
    clock_.hostSlept(hostSlept());
    observation->timestamp = rawlog::toMrptTime(clock_.stamp(t, now));
  }

  void fail(const std::string& problem) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const bool never = status_.restarts == 0 && status_.observations == 0;
      status_.state = never ? SensorState::missing : SensorState::waiting;
      if (status_.problem == problem && said_) return;
      status_.problem = problem;
      said_ = true;
    }
    warn(problem + "; it is tried again");
  }

  void setState(SensorState state) {
    bool back = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (status_.state == state) return;
      back = status_.state != SensorState::starting && state == SensorState::running;
      status_.state = state;
      said_ = false;
    }
    // Not under the mutex: who hears it may ask for status().
    if (back) say(LogLevel::info, "works again");
  }
  void warn(const std::string& text) { say(LogLevel::warning, text); }
  void say(LogLevel level, const std::string& text) const {
    const std::lock_guard<std::mutex> lock(owner_->log_mutex_);
    log(owner_->log_, level, section_.name + ": " + text);
  }

  bool stopped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stop_;
  }
  void sleepFor(double s) { sleepUntil(SteadyClock::now() + seconds(s)); }
  void sleepUntil(SteadyClock::time_point when) {
    std::unique_lock<std::mutex> lock(mutex_);
    wake_.wait_until(lock, when, [this] { return stop_; });
  }

  Acquisition* owner_;
  std::size_t index_;
  roles::SensorSection section_;
  bool keeps_stamps_, wants_states_ = false;
  mrpt::config::CConfigFileMemory config_;
  std::string image_folder_;
  std::unique_ptr<roles::Sensor> device_;
  DeviceClock clock_;
  std::optional<bool> own_clock_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false, said_ = false, connected_ = true;
  bool said_whole_ = false;  // of the thread
  SteadyClock::time_point counted_;
  SensorStatus status_;
  std::optional<News> to_tell_;
  std::thread thread_;
};

Acquisition::Acquisition(const Settings& settings, const std::string& image_folder,
                         const AcquisitionOptions& options, LogSink log)
    : options_(options), log_(std::move(log)) {
  for (const std::string& section : sensorSections(settings)) {
    sensors_.push_back(
        std::make_unique<Sensor>(this, sensors_.size(), settings, section, image_folder));
  }
  if (!sensors_.empty()) return;
  throw SettingsError({settings.name(), 0}, "", "", "no section with a driver: no sensor");
}

Acquisition::~Acquisition() { stop(); }

void Acquisition::start() {
  // A camera can take seconds; the others need not wait for it.
  std::vector<std::future<std::string>> starting;
  starting.reserve(sensors_.size());
  for (const auto& sensor : sensors_) {
    starting.push_back(std::async(std::launch::async, [&sensor] { return sensor->initialize(); }));
  }
  std::vector<std::string> problems;
  std::string missing;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    problems.push_back(starting[i].get());
    if (problems[i].empty() || sensors_[i]->optional()) continue;
    missing += (missing.empty() ? "" : "; ") + sensors_[i]->status().name + ": " + problems[i];
  }
  if (!missing.empty()) {
    throw std::runtime_error(missing +
                             " (with optional = true in its section a sensor may be missing)");
  }
  for (std::size_t i = 0; i < sensors_.size(); ++i) sensors_[i]->launch(problems[i]);
}

void Acquisition::deliver(std::vector<Arrival>* arrivals) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::move(arrivals->begin(), arrivals->end(), std::back_inserter(queue_));
  }
  wake_.notify_one();
}

std::vector<Arrival> Acquisition::take(TimeNs timeout) {
  std::unique_lock<std::mutex> lock(mutex_);
  wake_.wait_for(lock, std::chrono::nanoseconds(timeout), [this] { return !queue_.empty(); });
  return std::exchange(queue_, {});
}

bool Acquisition::ended() const {
  return std::all_of(sensors_.begin(), sensors_.end(),
                     [](const auto& sensor) { return sensor->ended(); });
}

void Acquisition::tell(const StateEstimate& estimate,
                       const std::function<std::vector<Anchor>()>& anchors) {
  for (const auto& sensor : sensors_) {
    if (sensor->wantsStates()) sensor->tell(estimate, anchors());
  }
}

void Acquisition::stop() {
  for (const auto& sensor : sensors_) sensor->stop();
}

std::vector<SensorStatus> Acquisition::sensors() const {
  std::vector<SensorStatus> all;
  for (const auto& sensor : sensors_) all.push_back(sensor->status());
  return all;
}

}  // namespace vir::live
