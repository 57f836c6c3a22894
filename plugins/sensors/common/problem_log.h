#pragma once
/// What could not be used, counted by kind; the first few of each kind in words.
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vir {

class ProblemLog {
 public:
  /// Messages kept in words per kind.
  static constexpr long kShown = 5;

  /// `counter` is the kind ("imu_not_finite"), `where` a file and line, `what` the reason.
  void add(const std::string& counter, const std::string& where, const std::string& what);
  /// Counts without a message.
  void count(const std::string& counter, long n = 1) { counts_[counter] += n; }
  /// All that another one holds.
  void takeOver(const ProblemLog& other);
  /// A message that belongs to no counter, said once.
  void note(const std::string& text);

  long get(const std::string& counter) const;
  std::vector<std::pair<std::string, long>> counters() const;
  /// Oldest first.
  const std::vector<std::string>& messages() const { return messages_; }
  /// The first message of a kind, or empty.
  std::string first(const std::string& counter) const;

 private:
  std::map<std::string, long> counts_;
  std::map<std::string, std::string> first_;
  std::vector<std::string> messages_;
};

}  // namespace vir
