#pragma once
/// What could not be used, counted by kind; the first of each kind in words.
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vir {

class ProblemLog {
 public:
  /// `counter` is the kind ("imu_not_finite"), `where` a file and line, `what` the reason. Each
  /// kind of each file has one message, of its first case, which says how many more there are.
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
  std::vector<std::string> messages() const;
  /// The first message of a kind, or empty.
  std::string first(const std::string& counter) const;

 private:
  struct Message {
    std::string text;
    long more = 0;  ///< cases of the same kind
  };
  void say(const std::string& kind, const Message& message);

  std::map<std::string, long> counts_;
  std::map<std::string, std::string> first_;
  std::vector<std::pair<std::string, Message>> said_;  // with their kinds
  std::map<std::string, std::size_t> kinds_;           // where in said_
};

}  // namespace vir
