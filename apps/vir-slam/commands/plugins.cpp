/// vir-slam plugins [NAME]: what is there, and the settings of one.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands/commands.h"
#include "robots/rendezvous_options.h"
#include "setup/run_options.h"
#include "vir/core/ini_writer.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/live_source.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/rendezvous_registry.h"
#include "vir/roles/sensor.h"
#include "vir/team/joint_solution.h"

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

/// The settings of the estimator, rendezvous solver or sensor `name` as a commented ini.
std::string reference(const std::string& name) {
  IniWriter writer(IniWriter::Style::reference);
  const std::string head =
      "// Every setting with its default. Written by: vir-slam plugins " + name + "\n\n";
  for (const auto& e : roles::registeredEstimators()) {
    if (e.name != name) continue;
    RunOptions run;
    run.driver = name;
    describe(writer, run);
    roles::estimatorSettings(name)->describe(writer);
    return head + writer.text();
  }
  for (const auto& r : roles::registeredRendezvous()) {
    if (r.name != name) continue;
    RendezvousRunOptions run;
    team::JointOptions joint;
    run.driver = name;
    describe(writer, run);
    roles::createRendezvous(name)->describe(writer);
    team::describe(writer, joint);
    return head + writer.text();
  }
  const auto sensor = roles::openSensor(name);
  if (auto* recorded = sensor->recorded()) recorded->describe(writer);
  if (auto* live = sensor->live()) live->describe(writer);
  return head + writer.text();
}

}  // namespace

void addPlugins(CLI::App& app, Common& common) {
  const auto name = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("plugins",
                                         "List the plugins, or the settings of one\n"
                                         "Examples:\n"
                                         "  vir-slam plugins\n"
                                         "  vir-slam plugins vir > ini/reference.ini");
  command->add_option("NAME", *name,
                      "Estimator, rendezvous solver or sensor: print its settings as an ini");
  command->callback([name, &common] {
    loadPlugins(common, roles::kAllPluginRoles);
    if (name->empty()) {
      list();
    } else {
      std::fputs(reference(*name).c_str(), stdout);
    }
  });
}

}  // namespace vir::app
