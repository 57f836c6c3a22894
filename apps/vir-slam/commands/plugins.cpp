/// vir-slam plugins [NAME]: what is there, and the settings of one.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands/commands.h"
#include "output/settings_text.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/rendezvous_registry.h"
#include "vir/roles/sensor.h"

namespace vir::app {
namespace {

void printRow(const char* role, const std::string& name, const std::string& description,
              const std::string& file) {
  std::printf("%-10s %-14s %s\n%25s %s\n", role, name.c_str(), description.c_str(), "",
              file.c_str());
}

void list() {
  for (const auto& e : roles::registeredEstimators()) {
    printRow("estimator", e.name, e.description, e.plugin_file);
  }
  for (const auto& r : roles::registeredRendezvous()) {
    printRow("rendezvous", r.name, r.description, r.plugin_file);
  }
  for (const auto& s : roles::registeredSensors()) {
    printRow("sensor", s.alias, s.description + " (class " + s.class_name + ")", s.plugin_file);
  }
}

}  // namespace

void addPlugins(CLI::App& app, Common& common) {
  const auto name = std::make_shared<std::string>();
  const auto keys = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("plugins",
                                         "List the plugins, or the settings of one\n"
                                         "Examples:\n"
                                         "  vir-slam plugins\n"
                                         "  vir-slam plugins vir > ini/reference.ini");
  command->add_option("NAME", *name,
                      "Estimator, rendezvous solver or sensor: print its settings as an ini");
  command->add_flag("--keys", *keys, "Only the names of all settings, and what each is of");
  command->callback([name, keys, &common] {
    loadPlugins(common, roles::kAllPluginRoles);
    if (*keys) {
      std::fputs(settingsKeys().c_str(), stdout);
    } else if (name->empty()) {
      list();
    } else {
      std::fputs(settingsText(*name).c_str(), stdout);
    }
  });
}

}  // namespace vir::app
