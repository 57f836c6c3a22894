#include "commands/words.h"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "commands/commands.h"
#include "vir/core/nearest.h"
#include "vir/core/text.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using Words = std::vector<std::string>;

std::vector<const CLI::App*> commandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

Words namesOf(const std::vector<const CLI::App*>& commands) {
  Words names;
  for (const CLI::App* c : commands) names.push_back(c->get_name());
  return names;
}

/// Index of the first word at or after `from` that is neither an option nor the value of one.
std::size_t firstWord(const Words& words, std::size_t from, const CLI::App& app) {
  for (std::size_t i = from; i < words.size(); ++i) {
    if (words[i].empty() || words[i][0] != '-') return i;
    const CLI::Option* option = app.get_option_no_throw(words[i]);
    if (option != nullptr && option->get_items_expected_max() > 0) ++i;
  }
  return words.size();
}

bool looksLikeARecording(const std::string& word) {
  std::error_code ignored;
  if (fs::exists(word, ignored)) return true;
  const std::string extension = lowerCase(fs::path(word).extension().string());
  for (const char* known : {".rawlog", ".gz", ".bag", ".mcap", ".db3", ".mp4", ".ini"}) {
    if (extension == known) return true;
  }
  return false;
}

/// `at` is where there is no command.
[[noreturn]] void refuse(const Words& words, std::size_t at, const Words& names, bool at_root) {
  const std::string& word = words[at];
  std::string text = "there is no command '" + word + "'";
  Words meant = words;
  const std::string near = nearest(word, names);
  if (at_root && looksLikeARecording(word)) {
    meant.insert(meant.begin() + static_cast<std::ptrdiff_t>(at), "run");
  } else if (!near.empty()) {
    meant[at] = near;
  } else {
    for (const std::string& name : names)
      text += (&name == &names[0] ? "; there are: " : ", ") + name;
    throw UsageError(text + " (vir-slam --help)");
  }
  throw UsageError(text + "; did you mean: " + commandLine(meant));
}

}  // namespace

std::string commandLine(const Words& words) {
  std::string out = "vir-slam";
  for (const std::string& word : words) {
    const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$&;()<>|*?#") == word.npos;
    out += plain ? " " + word : " '" + word + "'";
  }
  return out;
}

std::vector<std::string> understood(Words words, const CLI::App& app) {
  std::size_t at = firstWord(words, 0, app);
  if (at == words.size()) return words;
  if (words[at] == "version") {
    words[at] = "--version";
    return words;
  }
  if (words[at] == "help") {
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(at));
    words.emplace_back("--help");
  }
  const CLI::App* parent = &app;
  for (at = firstWord(words, 0, app); at < words.size(); at = firstWord(words, at + 1, *parent)) {
    const std::vector<const CLI::App*> commands = commandsOf(*parent);
    if (commands.empty()) break;
    const CLI::App* found = nullptr;
    for (const CLI::App* c : commands) found = c->get_name() == words[at] ? c : found;
    if (found == nullptr) refuse(words, at, namesOf(commands), parent == &app);
    parent = found;
  }
  return words;
}

std::string optionHint(const CLI::App& app) {
  const CLI::App* called = &app;
  while (!called->get_subcommands().empty()) called = called->get_subcommands().front();
  Words known;
  for (const CLI::App* a : {called, &app}) {
    for (const CLI::Option* option : a->get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
  }
  for (const std::string& word : app.remaining(true)) {
    if (word.rfind("--", 0) != 0) continue;
    const std::string near = nearest(word.substr(0, word.find('=')), known);
    if (!near.empty()) return "did you mean " + near + "?";
  }
  return {};
}

}  // namespace vir::app
