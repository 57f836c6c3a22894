#include "problem_log.h"

namespace vir {
namespace {

/// `file` of `file:12`; else nothing.
std::string fileOf(const std::string& where) {
  const std::size_t colon = where.rfind(':');
  const bool line = colon != std::string::npos && colon + 1 < where.size() &&
                    where.find_first_not_of("0123456789", colon + 1) == std::string::npos;
  return line ? where.substr(0, colon) : std::string();
}

}  // namespace

void ProblemLog::say(const std::string& kind, const Message& message) {
  const auto [known, is_new] = kinds_.emplace(kind, said_.size());
  if (is_new) {
    said_.emplace_back(kind, message);
  } else {
    said_[known->second].second.more += 1 + message.more;
  }
}

void ProblemLog::add(const std::string& counter, const std::string& where,
                     const std::string& what) {
  ++counts_[counter];
  const std::string text = where + ": " + what;
  first_.emplace(counter, text);
  say(counter + " of " + fileOf(where), {text});
}

void ProblemLog::takeOver(const ProblemLog& other) {
  for (const auto& [counter, n] : other.counts_) counts_[counter] += n;
  for (const auto& [counter, text] : other.first_) first_.emplace(counter, text);
  for (const auto& [kind, message] : other.said_) {
    const bool note = kind.compare(0, 5, "note:") == 0;
    if (!note || kinds_.count(kind) == 0) say(kind, message);
  }
}

void ProblemLog::note(const std::string& text) {
  const std::string kind = "note:" + text;
  if (kinds_.count(kind) == 0) say(kind, {text});
}

long ProblemLog::get(const std::string& counter) const {
  const auto it = counts_.find(counter);
  return it == counts_.end() ? 0 : it->second;
}

std::vector<std::pair<std::string, long>> ProblemLog::counters() const {
  return {counts_.begin(), counts_.end()};
}

std::vector<std::string> ProblemLog::messages() const {
  std::vector<std::string> out;
  for (const auto& [kind, m] : said_) {
    out.push_back(m.more == 0 ? m.text
                              : m.text + " (and " + std::to_string(m.more) + " more like this)");
  }
  return out;
}

std::string ProblemLog::first(const std::string& counter) const {
  const auto it = first_.find(counter);
  return it == first_.end() ? std::string() : it->second;
}

}  // namespace vir
