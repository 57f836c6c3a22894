#pragma once
/// Options that a program filled in, checked as strictly as a file's.
#include <string>
#include <vector>

#include "vir/core/options.h"

namespace vir {
inline namespace core {

/// Throws std::invalid_argument `[section] key = value: problem`; `problem` says what is allowed.
[[noreturn]] void refuseSetting(const std::string& section, const std::string& key,
                                const std::string& value, const std::string& problem);

/// Refuses the first value that its declaration does not allow; not a number is none.
class OptionCheck final : public OptionVisitor {
 public:
  void section(const std::string& name, const std::string&) override { section_ = name; }
  void value(const char*, bool&, const char*) override {}
  void value(const char* key, int& v, Bounds<int> bounds, const char*) override;
  void value(const char* key, double& v, Bounds<double> bounds, const char*) override;
  void value(const char*, std::string&, const char*) override {}
  void value(const char* key, std::vector<double>& v, std::size_t size, const char*) override;
  void choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
              const char*) override;

 private:
  std::string section_;
};

/// All that describe(OptionVisitor&, Options&) declares.
template <typename Options>
void checkBounds(Options options) {
  OptionCheck check;
  describe(check, options);
}

}  // namespace core
}  // namespace vir
