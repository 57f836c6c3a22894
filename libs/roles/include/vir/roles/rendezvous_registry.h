#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vir/roles/rendezvous.h"

namespace vir::roles {

using RendezvousFactory = std::function<std::unique_ptr<Rendezvous>()>;

struct RendezvousEntry {
  std::string name;         ///< `driver =` in [Rendezvous]
  std::string description;  ///< one line
  std::string plugin_file;  ///< path of the shared object; empty if linked in
};

/// Called by VIR_REGISTER_RENDEZVOUS while a plugin is being loaded. Never throws: a clash of names
/// is kept and reported by the loader.
void registerRendezvous(const std::string& name, RendezvousFactory factory,
                        const std::string& description);

/// All solvers registered so far, ordered by name.
std::vector<RendezvousEntry> registeredRendezvous();

/// Throws PluginError (plugin_loader.h) that lists what is available.
std::unique_ptr<Rendezvous> createRendezvous(const std::string& name);

}  // namespace vir::roles

/// In a plugin's register.cpp: VIR_REGISTER_RENDEZVOUS(NloptRendezvous, "nlopt", "what it is")
/// `Class` is written without namespace and has a default constructor.
#define VIR_REGISTER_RENDEZVOUS(Class, name, description)                                          \
  namespace {                                                                                      \
  const bool vir_rendezvous_registered_##Class = [] {                                              \
    ::vir::roles::registerRendezvous(                                                              \
        name, [] { return std::unique_ptr<::vir::roles::Rendezvous>(new Class()); }, description); \
    return true;                                                                                   \
  }();                                                                                             \
  }                                                                                                \
  static_assert(true, "")
