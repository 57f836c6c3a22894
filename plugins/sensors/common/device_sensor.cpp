#include "device_sensor.h"

#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>

#include <stdexcept>

#include "live_logger.h"
#include "vir/core/host_clock.h"
#include "vir/core/resource_usage.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/grabber_settings.h"

namespace vir {
namespace {

constexpr int kWaitMs = 20;
constexpr int kMostReads = 16;  // per doProcess()
constexpr double kMuteS = 5;    // bytes without a message for so long are worth a word
constexpr std::uint64_t kMuteBytes = 500;

}  // namespace

DeviceSensor::DeviceSensor(const std::string& driver, std::string label)
    : COutputLogger(driver), default_label_(std::move(label)) {
  m_sensorLabel = default_label_;
  reports_.setSink(sinkOf(this));
}

void DeviceSensor::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                             const std::string& section) {
  roles::readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
  setLoggerName(section);
  // MRPT's word for a label that is not set.
  const bool unset = m_sensorLabel.empty() || m_sensorLabel == "UNNAMED_SENSOR";
  if (unset) m_sensorLabel = default_label_;
}

void DeviceSensor::initialize() {
  m_state = ssInitializing;
  source_ = std::make_unique<ByteSource>(port());
  clock_.reset();
  reopened_ = understood_ = 0;
  bytes_then_ = 0;
  begin();
  source_->open();
  understood_s_ = wallSeconds();
  m_state = ssWorking;
}

void DeviceSensor::doProcess() {
  if (!source_) throw std::logic_error(getLoggerName() + ": doProcess() before initialize()");
  std::uint8_t buffer[4096];
  for (int i = 0; i < kMostReads; ++i) {
    const std::size_t n = source_->read(buffer, sizeof buffer, i == 0 ? kWaitMs : 0);
    const TimeNs arrival = hostNow();
    noteReopening();
    if (n == 0) break;
    take(buffer, n, arrival);
  }
  const double now_s = wallSeconds();
  noteNothingUnderstood(now_s);
  converse(now_s);
  for (const std::string& event : source_->takeEvents()) reports_.say(LogLevel::warning, event);
}

void DeviceSensor::noteReopening() {
  if (source_->reopened() == reopened_) return;
  reopened_ = source_->reopened();
  forgetHalfMessages();
}

void DeviceSensor::noteNothingUnderstood(double now_s) {
  const long messages = understood();
  if (messages != understood_ || !connected()) {
    understood_ = messages;
    understood_s_ = now_s;
    bytes_then_ = source_->bytes();
    reports_.forget("mute");
    return;
  }
  const std::uint64_t bytes = source_->bytes() - bytes_then_;
  if (now_s < understood_s_ + kMuteS || bytes < kMuteBytes) return;
  reports_.once("mute", LogLevel::warning,
                port().port + ": " + std::to_string(bytes) + " bytes came, but " + whyNothing());
}

TimeNs DeviceSensor::onHostClock(TimeNs device_time, TimeNs arrival, TimeNs wrap) {
  if (!clock_) {
    DeviceClockOptions options;
    options.wrap = wrap;
    clock_ = std::make_unique<DeviceClock>(options);
  }
  clock_->hostSlept(hostSlept());
  return clock_->stamp(device_time, arrival);
}

void DeviceSensor::addPortCounts(Counts* counts) const {
  addCounts({{"reopened", reopened_},
             {"clock_restarts", clock_ ? clock_->restarts() : 0},
             {"clock_glitches", clock_ ? clock_->glitches() : 0}},
            counts);
}

bool DeviceSensor::connected() const {
  return source_ != nullptr && source_->state() == ByteSource::State::open;
}

std::vector<roles::SensorMessage> DeviceSensor::takeMessages() { return reports_.take(); }

}  // namespace vir
