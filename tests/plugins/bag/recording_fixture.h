#pragma once
/// A bag of one's own, read as readings in time order.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "bag_recording.h"
#include "vir_test_bag_writer.h"
#include "vir_test_temp_folder.h"

namespace vir::bag {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kStart = 1'600'000'000LL * 1'000 * kMs;

class Recording : public testing::Test {
 protected:
  std::string path() const { return (folder_ / "x.bag").string(); }

  std::vector<Reading> readAll(const std::string& topics = "") {
    options.source = path();
    if (!topics.empty()) options.topics = topics;
    log = {};
    recording = std::make_unique<BagRecording>(options, &log);
    std::vector<Reading> out;
    for (Reading r; recording->next(&r);) out.push_back(std::move(r));
    for (std::size_t i = 1; i < out.size(); ++i) EXPECT_LE(out[i - 1].t, out[i].t);
    return out;
  }
  std::string complaint(const std::string& topics = "") {
    try {
      readAll(topics);
      return "";
    } catch (const std::runtime_error& e) {
      return e.what();
    }
  }
  bool noted(const std::string& text) const {
    for (const std::string& m : log.messages()) {
      if (m.find(text) != std::string::npos) return true;
    }
    return false;
  }
  template <typename T>
  static std::vector<T> only(const std::vector<Reading>& readings, TimeNs* first = nullptr) {
    std::vector<T> out;
    for (const Reading& r : readings) {
      if (const T* x = std::get_if<T>(&r.what)) {
        if (out.empty() && first != nullptr) *first = r.t;
        out.push_back(*x);
      }
    }
    return out;
  }

  test::TempFolder folder_;
  BagOptions options;
  ProblemLog log;
  std::unique_ptr<BagRecording> recording;
};

}  // namespace vir::bag
