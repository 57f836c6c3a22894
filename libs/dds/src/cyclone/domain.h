#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "cyclone/dds_entities.h"
#include "vir/core/log.h"
#include "vir/dds/link.h"

namespace vir::dds {

/// The domain of this process, and a participant in it. Links with the same number share it: the
/// settings are those of the first.
class Domain {
 public:
  /// Throws std::runtime_error with what DDS has said.
  static std::shared_ptr<Domain> of(const LinkOptions& options, const LogSink& log);
  Domain(const LinkOptions& options, LogSink log);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;
  dds_entity_t participant() const { return participant_.get(); }

 private:
  static void onLog(void* self, const dds_log_data_t* data);

  LogSink log_;
  std::mutex mutex_;  // of what DDS says
  std::string last_said_;
  std::set<std::string> said_;
  std::atomic<bool> opened_{false};
  Entity domain_, participant_;
};

/// A handle that is one. Throws std::runtime_error naming `what`.
dds_entity_t checked(dds_entity_t handle, const std::string& what);

}  // namespace vir::dds
