#pragma once

namespace vir {
inline namespace core {

/// Lets go of what this process has mapped of the program's and the libraries' files and never
/// wrote to: code, symbol tables, relocations. Loading touches far more of it than is used
/// afterwards, and it counts as resident though the kernel can drop it whenever it likes; what is
/// needed again is read from the kernel's cache of files. Does nothing while a debugger is
/// attached, whose breakpoints stand in the code, and where the system is not Linux with glibc.
void releaseLoadedPages();

}  // namespace core
}  // namespace vir
