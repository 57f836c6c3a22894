#include "serial_imu.h"

#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/obs/CObservationIMU.h>

#include <chrono>
#include <stdexcept>

#include "live_logger.h"
#include "vir/core/settings.h"
#include "vir/pipeline/grabber_settings.h"
#include "vir/pipeline/mrpt_time.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(SerialImu, vir)

namespace {

constexpr int kWaitMs = 20;
constexpr int kMostReads = 16;  // per doProcess()
constexpr double kMuteS = 5;    // bytes without a reading for so long are worth a word
constexpr std::uint64_t kMuteBytes = 500;
constexpr TimeNs kTick = 100;  // of MRPT's clock

/// For intervals only.
double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TimeNs hostTime() { return fromMrptTime(mrpt::Clock::now()); }

}  // namespace

SerialImu::SerialImu() : COutputLogger("SerialImu") {
  m_sensorLabel = "IMU0";
  reports_.setSink(sinkOf(this));
}

SerialImu::~SerialImu() = default;

void SerialImu::describe(OptionVisitor& v) { serial_imu::describe(v, options_); }

void SerialImu::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                          const std::string& section) {
  readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
  setLoggerName(section);
  if (m_sensorLabel.empty() || m_sensorLabel == "UNNAMED_SENSOR") m_sensorLabel = "IMU0";
  try {
    axes_ = serial_imu::parseAxes(options_.axes);
  } catch (const std::invalid_argument& e) {
    throw SettingsError({"ini", 0}, section, "axes", e.what());
  }
}

void SerialImu::initialize() {
  m_state = ssInitializing;
  source_ = std::make_unique<ByteSource>(options_.source);
  parser_ = serial_imu::makeParser(options_.protocol, options_.limits, options_.mavlink);
  clock_.reset();
  reopened_ = restarts_told_ = given_ = messages_seen_ = 0;
  bytes_at_message_ = 0;
  source_->open();
  message_s_ = steadySeconds();
  m_state = ssWorking;
}

void SerialImu::doProcess() {
  if (!source_) throw std::logic_error("SerialImu: doProcess() before initialize()");
  std::uint8_t buffer[4096];
  for (int i = 0; i < kMostReads; ++i) {
    const std::size_t n = source_->read(buffer, sizeof buffer, i == 0 ? kWaitMs : 0);
    const TimeNs arrival = hostTime();
    noteReopening();
    if (n == 0) break;
    readings_.clear();
    parser_->feed(buffer, n, &readings_);
    for (const serial_imu::ImuReading& reading : readings_) emit(reading, arrival);
  }
  noteSilentParser(steadySeconds());
  noteClock();
  for (const std::string& event : source_->takeEvents()) reports_.say(LogLevel::warning, event);
}

void SerialImu::noteReopening() {
  if (source_->reopened() == reopened_) return;
  reopened_ = source_->reopened();
  parser_->reset();
}

void SerialImu::noteClock() {
  if (!clock_) return;
  if (clock_->restarts() != restarts_told_) {
    restarts_told_ = clock_->restarts();
    reports_.say(LogLevel::warning, options_.source.port +
                                        ": the device started again, or a clock was set; its "
                                        "stamps are fitted anew");
  }
  if (clock_->driftKnown()) {
    reports_.once("drift", LogLevel::info,
                  options_.source.port + ": the device's clock is off by " +
                      std::to_string(clock_->driftPpm()) + " ppm");
  }
}

/// Bytes but no readings: the user should know why.
void SerialImu::noteSilentParser(double now_s) {
  const long readings = parser_->counters().readings;
  if (readings != messages_seen_ || !connected()) {
    messages_seen_ = readings;
    message_s_ = now_s;
    bytes_at_message_ = source_->bytes();
    reports_.forget("mute");
    return;
  }
  const std::uint64_t bytes = source_->bytes() - bytes_at_message_;
  if (now_s < message_s_ + kMuteS || bytes < kMuteBytes) return;
  const serial_imu::ParserCounters& c = parser_->counters();
  std::string why =
      "is baud = " + std::to_string(options_.source.baud) + " right, and the protocol?";
  if (options_.protocol == "mavlink" && c.incomplete > 0) {
    why = "its HIGHRES_IMU messages do not mark accelerometer and gyro as updated";
  } else if (options_.protocol == "mavlink") {
    why += " Does the autopilot send HIGHRES_IMU (or SCALED_IMU) on this link?";
  }
  reports_.once(
      "mute", LogLevel::warning,
      options_.source.port + ": " + std::to_string(bytes) + " bytes came, but no reading; " + why);
}

TimeNs SerialImu::stampOf(const serial_imu::ImuReading& reading, TimeNs arrival) {
  TimeNs t = arrival;
  if (options_.stamp == "device") {
    if (!clock_ || clock_wrap_ != parser_->clockWrap()) {
      DeviceClockOptions o;
      o.wrap = clock_wrap_ = parser_->clockWrap();
      clock_ = std::make_unique<DeviceClock>(o);
    }
    t = clock_->stamp(reading.device_time, arrival);
  }
  t -= fromSeconds(options_.latency_s);
  last_stamp_ = std::max(last_stamp_ + kTick, t);
  return last_stamp_;
}

void SerialImu::emit(const serial_imu::ImuReading& reading, TimeNs arrival) {
  using namespace mrpt::obs;
  const auto acc = axes_.toBody(reading.acc_m_s2);
  const auto gyro = axes_.toBody(reading.gyro_rad_s);
  auto obs = std::make_shared<CObservationIMU>();
  obs->timestamp = toMrptTime(stampOf(reading, arrival));
  obs->sensorLabel = m_sensorLabel;
  obs->set(IMU_X_ACC, acc[0]);
  obs->set(IMU_Y_ACC, acc[1]);
  obs->set(IMU_Z_ACC, acc[2]);
  obs->set(IMU_WX, gyro[0]);
  obs->set(IMU_WY, gyro[1]);
  obs->set(IMU_WZ, gyro[2]);
  ++given_;
  appendObservation(obs);
}

bool SerialImu::connected() const {
  return source_ != nullptr && source_->state() == ByteSource::State::open;
}

std::vector<std::pair<std::string, long>> SerialImu::counters() const {
  std::vector<std::pair<std::string, long>> out = {{"imu_readings", given_}};
  if (!parser_) return out;
  const serial_imu::ParserCounters& c = parser_->counters();
  const std::pair<const char*, long> more[] = {
      {"messages", c.messages},
      {"implausible_readings", c.implausible},
      {"incomplete_readings", c.incomplete},
      {"lost_messages", c.lost},
      {"corrupt_messages", c.corrupt},
      {"other_messages", c.ignored},
      {"other_text", c.other_text},
      {"skipped_bytes", static_cast<long>(c.skipped_bytes)},
      {"reopened", reopened_},
      {"clock_restarts", clock_ ? clock_->restarts() : 0},
      {"clock_glitches", clock_ ? clock_->glitches() : 0}};
  for (const auto& [name, n] : more) {
    if (n != 0) out.emplace_back(name, n);
  }
  return out;
}

std::vector<std::string> SerialImu::takeMessages() { return reports_.take(); }

}  // namespace vir
