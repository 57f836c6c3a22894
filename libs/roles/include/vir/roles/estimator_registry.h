#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::roles {

using EstimatorFactory = std::function<std::unique_ptr<EstimatorSettings>()>;

struct EstimatorEntry {
  std::string name;         ///< `driver =` in [Estimator]
  std::string description;  ///< one line
  std::string plugin_file;  ///< path of the shared object; empty if linked in
};

/// Called by VIR_REGISTER_ESTIMATOR while a plugin is being loaded. Never throws: a clash of names
/// is kept and reported by the loader.
void registerEstimator(const std::string& name, EstimatorFactory factory,
                       const std::string& description);

/// All estimators registered so far, ordered by name.
std::vector<EstimatorEntry> registeredEstimators();

/// The settings of the estimator `name`, all at their defaults. Throws PluginError
/// (plugin_loader.h) that lists what is available.
std::unique_ptr<EstimatorSettings> estimatorSettings(const std::string& name);

}  // namespace vir::roles

/// In a plugin's register.cpp: VIR_REGISTER_ESTIMATOR(VirSettings, "vir", "what it is")
/// `Class` is an EstimatorSettings, written without namespace, with a default constructor.
#define VIR_REGISTER_ESTIMATOR(Class, name, description)                                    \
  namespace {                                                                               \
  const bool vir_estimator_registered_##Class = [] {                                        \
    ::vir::roles::registerEstimator(                                                        \
        name, [] { return std::unique_ptr<::vir::roles::EstimatorSettings>(new Class()); }, \
        description);                                                                       \
    return true;                                                                            \
  }();                                                                                      \
  }                                                                                         \
  static_assert(true, "")
