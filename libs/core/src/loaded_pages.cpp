#include "vir/core/loaded_pages.h"

#include <cstdlib>  // tells which library of C this is

#ifdef __GLIBC__
#include <link.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#endif

namespace vir {
inline namespace core {
#ifdef __GLIBC__
namespace {

bool traced() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "TracerPid:") continue;
    int tracer = 1;
    status >> tracer;
    return tracer != 0;
  }
  return true;  // not told: nothing is risked
}

/// Relocations may be written into code that asks for it, which then is not what the file holds.
bool writesToCode(const dl_phdr_info& object) {
  for (int i = 0; i < object.dlpi_phnum; ++i) {
    const ElfW(Phdr)& part = object.dlpi_phdr[i];
    if (part.p_type != PT_DYNAMIC) continue;
    const auto* entry = reinterpret_cast<const ElfW(Dyn)*>(object.dlpi_addr + part.p_vaddr);
    for (; entry->d_tag != DT_NULL; ++entry) {
      if (entry->d_tag == DT_TEXTREL) return true;
      if (entry->d_tag == DT_FLAGS && (entry->d_un.d_val & DF_TEXTREL) != 0) return true;
    }
  }
  return false;
}

int releaseObject(dl_phdr_info* object, std::size_t /*size*/, void* /*nothing*/) {
  const std::string name = object->dlpi_name == nullptr ? "" : object->dlpi_name;
  // The kernel's own page of code has no file. The program's name is empty.
  if (!name.empty() && name.find('/') == std::string::npos) return 0;
  if (writesToCode(*object)) return 0;
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& part = object->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_W) != 0) continue;
    const std::uintptr_t begin = (object->dlpi_addr + part.p_vaddr) / page * page;
    const std::uintptr_t end = object->dlpi_addr + part.p_vaddr + part.p_filesz;
    // A failure leaves the pages where they are.
    madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
  }
  return 0;
}

}  // namespace

void releaseLoadedPages() {
  if (!traced()) dl_iterate_phdr(releaseObject, nullptr);
}
#else
void releaseLoadedPages() {}
#endif

}  // namespace core
}  // namespace vir
