#include "cyclone/domain.h"

#include <map>
#include <utility>

#include "cyclone/security.h"

namespace vir::dds {
namespace {

constexpr std::size_t kMostTexts = 50;  // of DDS that are logged

}  // namespace

dds_entity_t checked(dds_entity_t handle, const std::string& what) {
  if (handle < 0) throw std::runtime_error("DDS: no " + what + ": " + dds_strretcode(-handle));
  return handle;
}

std::shared_ptr<Domain> Domain::of(const LinkOptions& options, const LogSink& log) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Domain>> all;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<Domain> domain = all[options.domain].lock();
  if (!domain) all[options.domain] = domain = std::make_shared<Domain>(options, log);
  return domain;
}

Domain::Domain(const LinkOptions& o, LogSink log) : log_(std::move(log)) {
  dds_set_log_sink(&Domain::onLog, this);
  try {
    const auto number = static_cast<dds_domainid_t>(o.domain);
    domain_ = Entity(dds_create_domain(number, domainConfig(o).c_str()),
                     "domain " + std::to_string(o.domain) + " on interface " + o.interface);
    const Qos qos = newQos();
    if (!o.security.empty()) secure(qos.get(), o.security);
    participant_ = Entity(dds_create_participant(number, qos.get(), nullptr), "participant");
  } catch (const std::runtime_error& e) {
    dds_set_log_sink(nullptr, nullptr);
    const std::lock_guard<std::mutex> lock(mutex_);
    throw std::runtime_error(e.what() + (last_said_.empty() ? "" : " (" + last_said_ + ")"));
  }
  opened_ = true;
}

Domain::~Domain() { dds_set_log_sink(nullptr, nullptr); }

/// In any thread of DDS.
void Domain::onLog(void* self, const dds_log_data_t* data) {
  auto* domain = static_cast<Domain*>(self);
  std::string text(data->message, data->size);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  const std::lock_guard<std::mutex> lock(domain->mutex_);
  domain->last_said_ = text;
  // A stranger who tries again and again is told of once.
  const bool new_text = domain->said_.size() < kMostTexts && domain->said_.insert(text).second;
  if (domain->opened_ && new_text) log(domain->log_, LogLevel::warning, "DDS: " + text);
}

}  // namespace vir::dds
