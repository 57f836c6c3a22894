#pragma once
#include <gtest/gtest.h>

#include <string>

#include "vir/core/settings.h"

namespace vir::test {

/// The text of the SettingsError that `work` throws.
template <typename Work>
std::string settingsErrorOf(Work work) {
  try {
    work();
  } catch (const SettingsError& e) {
    return e.what();
  }
  return "no SettingsError";
}

}  // namespace vir::test
