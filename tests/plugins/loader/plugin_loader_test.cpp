/// Each way in which a plugin can be wrong has its own words.
#include "vir/roles/plugin_loader.h"

#include <gtest/gtest.h>

#include <fstream>

#include "vir/roles/estimator_registry.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using testing::Test;

std::string good(const std::string& name) {
  return test::buildDir() + "/tests/fixtures/good/libfixture_" + name + ".so";
}
std::string bad(const std::string& name) {
  return test::buildDir() + "/tests/fixtures/bad/libfixture_" + name + ".so";
}

template <typename Work>
std::string errorOf(Work work) {
  try {
    work();
  } catch (const roles::PluginError& e) {
    return e.what();
  }
  return "no PluginError";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(PluginLoader, LoadsAndCreditsWhatAPluginRegisters) {
  roles::loadPlugin(good("estimator"));
  roles::loadPlugin(good("sensor"));
  roles::loadPlugin(good("estimator"));  // again: nothing happens
  ASSERT_EQ(roles::registeredEstimators().size(), 1u);
  EXPECT_EQ(roles::registeredEstimators()[0].name, "counting");
  EXPECT_TRUE(has(roles::registeredEstimators()[0].plugin_file, "libfixture_estimator.so"));
  ASSERT_EQ(roles::registeredSensors().size(), 1u);
  EXPECT_EQ(roles::registeredSensors()[0].alias, "ticking");
  EXPECT_EQ(roles::registeredSensors()[0].class_name, "TickingSensor");
  EXPECT_NE(roles::estimatorSettings("counting"), nullptr);
  EXPECT_NE(roles::createSensor("ticking"), nullptr);
  EXPECT_NE(roles::createSensor("TickingSensor"), nullptr);
}

TEST(PluginLoader, FolderIsLoadedInNameOrder) {
  const auto files = roles::loadPluginFolder(test::buildDir() + "/tests/fixtures/good");
  ASSERT_EQ(files.size(), 2u);
  EXPECT_TRUE(has(files[0], "estimator"));
  EXPECT_TRUE(has(files[1], "sensor"));
}

using Roles = roles::PluginRoles;
constexpr roles::PluginRole kEstimator = roles::PluginRole::estimator;
constexpr roles::PluginRole kSensor = roles::PluginRole::sensor;

TEST(PluginLoader, RolesAreToldWithoutLoading) {
  EXPECT_EQ(roles::rolesOfPlugin(good("estimator")), Roles{kEstimator});
  EXPECT_EQ(roles::rolesOfPlugin(good("sensor")), Roles{kSensor});
  const std::string folder = test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_";
  EXPECT_EQ(roles::rolesOfPlugin(folder + "nlopt.so"), Roles{roles::PluginRole::rendezvous});
  EXPECT_EQ(roles::rolesOfPlugin(folder + "vir.so"), Roles{kEstimator});
}

TEST(PluginLoader, OnlyWhatHasTheRoleIsLoaded) {
  const std::string folder = test::buildDir() + "/tests/fixtures/good";
  const auto estimators = roles::loadPluginFolder(folder, {kEstimator});
  ASSERT_EQ(estimators.size(), 1u);
  EXPECT_TRUE(has(estimators[0], "libfixture_estimator.so"));
  EXPECT_TRUE(roles::loadPluginFolder(folder, {roles::PluginRole::rendezvous}).empty());
  EXPECT_TRUE(roles::loadPluginFolder(folder, {}).empty());
}

/// What cannot be told is loaded for every role: then the dynamic linker says what is wrong.
TEST(PluginLoader, WhatDoesNotTellItsRoleMayHaveAny) {
  const test::TempFolder folder;
  const std::string file = (folder / "libx.so").string();
  EXPECT_EQ(roles::rolesOfPlugin(file), roles::kAllPluginRoles);  // there is none
  EXPECT_EQ(roles::rolesOfPlugin(bad("empty")), roles::kAllPluginRoles);
  test::writeText(file, "this is text\n");
  EXPECT_TRUE(has(errorOf([&] { roles::loadPluginFolder(folder.path().string(), {kSensor}); }),
                  "cannot load plugin"));
  const std::string sound = test::readText(good("estimator"));
  for (const std::size_t bytes : {0u, 3u, 16u, 63u, 64u, 300u, 900u}) {
    test::writeText(file, sound.substr(0, bytes));
    EXPECT_EQ(roles::rolesOfPlugin(file), roles::kAllPluginRoles) << bytes;
  }
  // Headers that promise more than there is.
  for (std::size_t at = 16; at < 1200; at += 4) {
    std::string damaged = sound;
    for (std::size_t i = at; i < at + 8; ++i) damaged[i] = static_cast<char>(0xff);
    test::writeText(file, damaged);
    EXPECT_FALSE(roles::rolesOfPlugin(file).empty()) << at;
  }
}

TEST(PluginLoader, MissingFile) {
  const std::string text = errorOf([] { roles::loadPlugin("/nowhere/libx.so"); });
  EXPECT_EQ(text, "there is no plugin file /nowhere/libx.so");
}

TEST(PluginLoader, MissingFolder) {
  const std::string text = errorOf([] { roles::loadPluginFolder("/nowhere"); });
  EXPECT_TRUE(has(text, "no plugin folder /nowhere")) << text;
}

TEST(PluginLoader, NotASharedObject) {
  const test::TempFolder folder;
  test::writeText(folder / "libtext.so", "this is text\n");
  const std::string text = errorOf([&] { roles::loadPlugin((folder / "libtext.so").string()); });
  EXPECT_TRUE(has(text, "cannot load plugin")) << text;
  EXPECT_TRUE(has(text, "libtext.so")) << text;
}

TEST(PluginLoader, UndefinedSymbolIsNamed) {
  const std::string text = errorOf([] { roles::loadPlugin(bad("undefined")); });
  EXPECT_TRUE(has(text, "cannot load plugin")) << text;
  EXPECT_TRUE(has(text, "definedNowhere")) << text;
}

TEST(PluginLoader, DuplicateNameNamesBothPlugins) {
  roles::loadPlugin(good("estimator"));
  const std::string text = errorOf([] { roles::loadPlugin(bad("twin")); });
  EXPECT_TRUE(has(text, "estimator 'Counting' is registered twice")) << text;
  EXPECT_TRUE(has(text, "libfixture_estimator.so")) << text;
  EXPECT_TRUE(has(text, "libfixture_twin.so")) << text;
  EXPECT_NE(roles::estimatorSettings("counting"), nullptr);  // the first one stays
}

TEST(PluginLoader, ClassThatMrptHasAlready) {
  const std::string text = errorOf([] { roles::loadPlugin(bad("twin_sensor")); });
  EXPECT_TRUE(has(text, "MRPT has a class CCameraSensor already")) << text;
}

TEST(PluginLoader, PluginThatRegistersNothing) {
  const std::string text = errorOf([] { roles::loadPlugin(bad("empty")); });
  EXPECT_TRUE(has(text, "registers nothing")) << text;
}

TEST(PluginLoader, UnknownNamesListWhatThereIs) {
  if (roles::registeredEstimators().empty()) {  // ctest runs each case in a process of its own
    EXPECT_TRUE(has(errorOf([] { roles::estimatorSettings("nope"); }), "none (no plugin loaded)"));
  }
  roles::loadPluginFolder(test::buildDir() + "/tests/fixtures/good");
  EXPECT_EQ(errorOf([] { roles::estimatorSettings("nope"); }),
            "unknown estimator 'nope'; available: counting");
  EXPECT_EQ(errorOf([] { roles::createSensor("nope"); }),
            "unknown sensor driver 'nope'; available: ticking");
}

}  // namespace
}  // namespace vir
