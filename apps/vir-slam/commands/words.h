#pragma once
/// The words of a command line before they are parsed: other ways to ask for help, and what was
/// meant where there is no such command.
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace vir::app {

/// `help run`, `version` and the like as options. Throws UsageError that names what was probably
/// meant if the first word, or that after a command with commands of its own, is none.
std::vector<std::string> understood(std::vector<std::string> words, const CLI::App& app);

/// The command of these words, as a shell takes it.
std::string commandLine(const std::vector<std::string>& words);

/// "did you mean --rawlog?" for an option that the command called does not have; may be empty.
std::string optionHint(const CLI::App& app);

}  // namespace vir::app
