#pragma once
/// What the pages of the documentation tell people to type.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "vir_test_paths.h"

namespace vir::test {

inline std::filesystem::path sourceRoot() { return sourceDir(); }

inline std::vector<std::filesystem::path> pages() {
  std::vector<std::filesystem::path> out{sourceRoot() / "README.md",
                                         sourceRoot() / "rawlog/README.md"};
  for (const auto& item : std::filesystem::directory_iterator(sourceRoot() / "docs")) {
    if (item.path().extension() == ".md") out.push_back(item.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// What stands between backticks, a line each; a sentence may break inside.
inline std::string spansIn(const std::string& prose) {
  std::string out;
  std::size_t at = 0;
  while ((at = prose.find('`', at)) != std::string::npos) {
    const std::size_t end = prose.find('`', at + 1);
    if (end == std::string::npos) break;
    out += prose.substr(at + 1, end - at - 1) + "\n";
    at = end + 1;
  }
  return out;
}

/// The code of a page: blocks in fences or set in by four blanks, and spans in sentences.
inline std::string codeIn(const std::string& text) {
  std::istringstream in(text);
  std::string code, prose;
  bool fenced = false;
  for (std::string line; std::getline(in, line);) {
    const bool fence = line.rfind("```", 0) == 0;
    if (fence) fenced = !fenced;
    if (fence) continue;
    if (fenced || line.rfind("    ", 0) == 0) {
      code += line + "\n";
    } else {
      prose += line + " ";
    }
  }
  return std::regex_replace(code, std::regex("\\\\\n"), " ") + spansIn(prose);
}

/// All that follows `vir-slam ` in code, up to its end; lines that go on are joined.
inline std::vector<std::string> commandsIn(const std::string& text) {
  const std::string all = "\n" + codeIn(text);
  const std::regex command("[\n|(] *(?:\\$ )?(?:build/bin/)?vir-slam ([^\n|)]*)");
  std::vector<std::string> out;
  for (std::sregex_iterator i(all.begin(), all.end(), command), end; i != end; ++i) {
    const std::string found = (*i)[1];
    out.push_back(found.substr(0, found.find(" #")));
  }
  return out;
}

inline std::vector<std::string> wordsIn(const std::string& command) {
  std::istringstream in(command);
  std::vector<std::string> out;
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

}  // namespace vir::test
