#pragma once
#include <string>
#include <utility>
#include <vector>

#include "vir/core/options.h"

namespace vir {
inline namespace core {

/// Writes options as ini text: the values in effect (`used.ini`) or, with what each one means and
/// may be, the reference. The values passed in are not changed. Options of one section that several
/// components declare end up under one heading.
class IniWriter : public OptionVisitor {
 public:
  enum class Style { values, reference };
  explicit IniWriter(Style style) : style_(style) {}

  void section(const std::string& name, const std::string& doc) override;
  void value(const char* key, bool& v, const char* doc) override;
  void value(const char* key, int& v, Bounds<int> bounds, const char* doc) override;
  void value(const char* key, double& v, Bounds<double> bounds, const char* doc) override;
  void value(const char* key, std::string& v, const char* doc) override;
  void value(const char* key, std::vector<double>& v, std::size_t size, const char* doc) override;
  void choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
              const char* doc) override;

  std::string text() const;

 private:
  struct Section {
    std::string name, doc, body;
  };
  void add(const char* key, const std::string& value, const std::string& allowed, const char* doc);

  Style style_;
  std::vector<Section> sections_;
  std::size_t current_ = 0;
};

/// The shortest text that reads back as the same number.
std::string numberText(double v);

}  // namespace core
}  // namespace vir
