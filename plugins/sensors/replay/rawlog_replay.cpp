#include "rawlog_replay.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "vir/core/host_clock.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/grabber_settings.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(RawlogReplay, vir)

namespace {

using SteadyClock = std::chrono::steady_clock;

}  // namespace

/// When a rawlog began to play: shared by all instances that play it.
struct RawlogReplay::Start {
  std::mutex mutex;
  std::optional<TimeNs> first;  ///< stamp of the rawlog's first object
  SteadyClock::time_point at;
  TimeNs host = 0;

  /// `wanted`: on the host's clock [ns since 1970]; 0 = now.
  void begin(TimeNs t, TimeNs wanted) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (first) return;
    first = t;
    const TimeNs now = hostNow();
    host = wanted > 0 ? wanted : now;
    at = SteadyClock::now() + std::chrono::nanoseconds(host - now);
  }
  static std::shared_ptr<Start> of(const std::string& rawlog) {
    static std::mutex all_mutex;
    static std::map<std::string, std::weak_ptr<Start>> all;
    const std::lock_guard<std::mutex> lock(all_mutex);
    std::shared_ptr<Start> start = all[rawlog].lock();
    if (!start) all[rawlog] = start = std::make_shared<Start>();
    return start;
  }
};

void describe(OptionVisitor& v, ReplayOptions& o) {
  v.section("replay", "A rawlog that comes in as if live");
  v.value("rawlog", o.rawlog, "the file");
  v.value("labels", o.labels, "sensor labels with blanks between; empty = all");
  v.value("speed", o.speed, {1e-3, 1e3}, "1 = as fast as it was recorded");
  v.value("start_at_s", o.start_at_s, {0, 4e9},
          "when it begins [s since 1970], to be in step with another program; 0 = at once");
  v.choice("stamps", o.stamps, {"keep", "now"},
           "as recorded (then set clock = keep too), or moved to the time it is played");
}

RawlogReplay::RawlogReplay() { m_sensorLabel = "replay"; }
RawlogReplay::~RawlogReplay() = default;

void RawlogReplay::describe(OptionVisitor& v) { vir::describe(v, options_); }

void RawlogReplay::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                             const std::string& section) {
  roles::readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
}

void RawlogReplay::initialize() {
  if (options_.rawlog.empty()) throw std::runtime_error("replay: no rawlog named");
  std::istringstream words(options_.labels);
  labels_.clear();
  for (std::string label; words >> label;) labels_.insert(label);
  reader_ = std::make_unique<rawlog::RawlogReader>(options_.rawlog);
  start_ = Start::of(options_.rawlog);
  next_ = reader_->next();
  if (!next_) throw std::runtime_error("replay: there is no observation in " + options_.rawlog);
  m_state = ssWorking;
}

bool RawlogReplay::wanted(const mrpt::obs::CObservation& observation) const {
  return labels_.empty() || labels_.count(observation.sensorLabel) > 0;
}

void RawlogReplay::readOn() {
  next_ = reader_->next();
  if (next_) return;
  finished_ = true;
  for (const std::string& problem : {reader_->damage(), reader_->refusals()}) {
    if (!problem.empty()) warnings_.push_back(problem);
  }
}

void RawlogReplay::doProcess() {
  if (!reader_) throw std::runtime_error("replay: doProcess() before initialize()");
  if (finished_) return;
  start_->begin(rawlog::fromMrptTime(next_->timestamp), fromSeconds(options_.start_at_s));
  const std::chrono::duration<double> played = SteadyClock::now() - start_->at;
  const TimeNs until = *start_->first + fromSeconds(played.count() * options_.speed);
  while (next_ && rawlog::fromMrptTime(next_->timestamp) <= until) {
    if (wanted(*next_)) {
      ++given_[next_->sensorLabel];
      if (options_.stamps == "now") {
        const double after = toSeconds(rawlog::fromMrptTime(next_->timestamp) - *start_->first);
        next_->timestamp = rawlog::toMrptTime(start_->host + fromSeconds(after / options_.speed));
      }
      appendObservation(next_);
    }
    readOn();
  }
}

double RawlogReplay::progress() const { return reader_ ? reader_->progress() : 0; }

std::vector<std::pair<std::string, long>> RawlogReplay::counters() const {
  return {given_.begin(), given_.end()};
}

}  // namespace vir
