#pragma once
/// Text from files that others wrote: bounded, whatever they hold.
#include <cstddef>
#include <istream>
#include <string>

namespace vir {
inline namespace core {

/// Longer than any line of numbers, settings or markup that this program knows [byte].
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

/// As std::getline, but of a line longer than kLongestLine the rest is dropped, so that a binary
/// file given by mistake does not fill the memory.
bool readLine(std::istream& in, std::string* line);

/// Why `path` is nothing to read text from: a device gives bytes without end, a folder none. Empty
/// for files and pipes, and for what is not there.
std::string notAFile(const std::string& path);

/// Why there is no text in a file: "is empty"; empty for all others, and for what is not there.
std::string whyNoText(const std::string& path);

/// All of a text file, in UTF-8 (see TextStream). Throws std::runtime_error without the path in it:
/// no such file, a folder or a device, larger than `most` bytes, or why it cannot be read.
std::string readTextFile(const std::string& path, std::size_t most);

}  // namespace core
}  // namespace vir
