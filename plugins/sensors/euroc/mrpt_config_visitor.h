#pragma once
/// Reads described settings from MRPT's configuration objects, strictly, so that a plugin used by
/// the stock rawlog-grabber is as careful as under our own command line.
#include <mrpt/config/CConfigFileBase.h>

#include <set>
#include <string>
#include <vector>

#include "vir/core/options.h"

namespace vir::euroc {

/// Throws InputError naming section, key and value for what is no number, out of bounds or not one
/// of the allowed words.
class MrptConfigVisitor : public OptionVisitor {
 public:
  MrptConfigVisitor(const mrpt::config::CConfigFileBase& config, std::string section)
      : config_(config), section_(std::move(section)) {}

  void section(const std::string&, const std::string&) override {}
  void value(const char* key, bool& v, const char*) override;
  void value(const char* key, int& v, Bounds<int> bounds, const char*) override;
  void value(const char* key, double& v, Bounds<double> bounds, const char*) override;
  void value(const char* key, std::string& v, const char*) override;
  void value(const char* key, std::vector<double>& v, std::size_t size, const char*) override;
  void choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
              const char*) override;

  /// Throws InputError if the section holds a key that neither was described nor belongs to every
  /// sensor of rawlog-grabber.
  void requireAllKnown() const;

 private:
  /// Text of the key without a trailing comment; false if it is not there.
  bool text(const char* key, std::string* out);
  [[noreturn]] void fail(const std::string& key, const std::string& value,
                         const std::string& wanted) const;
  double number(const char* key, const std::string& text) const;

  const mrpt::config::CConfigFileBase& config_;
  std::string section_;
  std::set<std::string> known_;
};

}  // namespace vir::euroc
