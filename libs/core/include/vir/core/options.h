#pragma once
/// How a component declares its settings: once, in a free function
///   void describe(OptionVisitor& v, TrackerOptions& o)
/// The same declaration reads an ini strictly, writes `used.ini` and generates `ini/reference.ini`.
#include <limits>
#include <string>
#include <vector>

namespace vir {
inline namespace core {

/// Inclusive bounds of a number.
template <typename T>
struct Bounds {
  T min = std::numeric_limits<T>::lowest();
  T max = std::numeric_limits<T>::max();
};

/// Visits every option of a component. `doc` is one line, says what the value does; the unit is in
/// the key (`_m _s _rad _deg _hz _px`). The reference passed in holds the default when the visitor
/// starts and the value read when it returns. A reading visitor throws SettingsError (settings.h).
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  /// Opens section [name]; options that follow belong to it.
  virtual void section(const std::string& name, const std::string& doc) = 0;
  virtual void value(const char* key, bool& v, const char* doc) = 0;
  virtual void value(const char* key, int& v, Bounds<int> bounds, const char* doc) = 0;
  virtual void value(const char* key, double& v, Bounds<double> bounds, const char* doc) = 0;
  virtual void value(const char* key, std::string& v, const char* doc) = 0;
  /// A list of numbers, written with blanks between; `size` 0 = any length.
  virtual void value(const char* key, std::vector<double>& v, std::size_t size,
                     const char* doc) = 0;
  /// One of a fixed set of words.
  virtual void choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
                      const char* doc) = 0;
};

}  // namespace core
}  // namespace vir
