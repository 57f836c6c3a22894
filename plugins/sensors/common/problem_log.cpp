#include "problem_log.h"

namespace vir {

void ProblemLog::add(const std::string& counter, const std::string& where,
                     const std::string& what) {
  const long n = ++counts_[counter];
  const std::string text = where + ": " + what;
  if (n == 1) first_[counter] = text;
  // What says the same of every reading is said once.
  const bool said = n > 1 && !messages_.empty() && messages_.back() == text;
  if (n <= kShown && !said) messages_.push_back(text);
  if (n == kShown + 1) messages_.push_back(counter + ": further cases are only counted");
}

void ProblemLog::takeOver(const ProblemLog& other) {
  for (const auto& [counter, n] : other.counts_) counts_[counter] += n;
  for (const auto& [counter, text] : other.first_) first_.emplace(counter, text);
  messages_.insert(messages_.end(), other.messages_.begin(), other.messages_.end());
}

void ProblemLog::note(const std::string& text) {
  if (first_.emplace("note:" + text, text).second) messages_.push_back(text);
}

long ProblemLog::get(const std::string& counter) const {
  const auto it = counts_.find(counter);
  return it == counts_.end() ? 0 : it->second;
}

std::vector<std::pair<std::string, long>> ProblemLog::counters() const {
  return {counts_.begin(), counts_.end()};
}

std::string ProblemLog::first(const std::string& counter) const {
  const auto it = first_.find(counter);
  return it == first_.end() ? std::string() : it->second;
}

}  // namespace vir
