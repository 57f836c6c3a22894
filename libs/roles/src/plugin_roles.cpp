/// What a plugin registers, without loading it (and all that it is linked to).
#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "vir/roles/plugin_loader.h"

namespace vir::roles {
namespace {

constexpr std::uint64_t kMostHeaders = 1024;  // segments or dynamic entries; others have some 30

class ElfFile {
 public:
  explicit ElfFile(const std::string& path) : file_(path, std::ios::binary) {}

  /// The names of its dynamic symbols, a zero behind each; empty if it has none.
  std::string names() {
    ElfW(Ehdr) head{};
    if (!read(0, &head, 1) || std::memcmp(head.e_ident, ELFMAG, SELFMAG) != 0) return {};
    const bool ours = head.e_ident[EI_CLASS] == (sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32);
    if (!ours || head.e_phentsize != sizeof(ElfW(Phdr)) || head.e_phnum > kMostHeaders) return {};
    segments_.resize(head.e_phnum);
    if (!read(head.e_phoff, segments_.data(), segments_.size())) return {};
    for (const ElfW(Phdr) & segment : segments_) {
      if (segment.p_type == PT_DYNAMIC) return namesBy(segment);
    }
    return {};
  }

 private:
  template <typename Item>
  bool read(std::uint64_t offset, Item* items, std::size_t count) {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(reinterpret_cast<char*>(items), static_cast<std::streamsize>(count * sizeof(Item)));
    return file_.good();
  }

  std::string namesBy(const ElfW(Phdr) & dynamic) {
    std::vector<ElfW(Dyn)> entries(
        std::min<std::uint64_t>(dynamic.p_filesz / sizeof(ElfW(Dyn)), kMostHeaders));
    if (!read(dynamic.p_offset, entries.data(), entries.size())) return {};
    std::uint64_t address = 0, size = 0;
    for (const ElfW(Dyn) & entry : entries) {
      if (entry.d_tag == DT_NULL) break;
      if (entry.d_tag == DT_STRTAB) address = entry.d_un.d_ptr;
      if (entry.d_tag == DT_STRSZ) size = entry.d_un.d_val;
    }
    for (const ElfW(Phdr) & segment : segments_) {
      if (segment.p_type != PT_LOAD || address < segment.p_vaddr) continue;
      const std::uint64_t inside = address - segment.p_vaddr;
      if (inside >= segment.p_filesz || size > segment.p_filesz - inside) continue;
      std::string text;
      if (!fits(segment.p_offset + inside, size)) return {};
      text.resize(size);
      return read(segment.p_offset + inside, text.data(), size) ? text : std::string();
    }
    return {};
  }

  /// A damaged header must not make room for more than there is.
  bool fits(std::uint64_t offset, std::uint64_t size) {
    file_.clear();
    file_.seekg(0, std::ios::end);
    const auto length = static_cast<std::uint64_t>(std::max<std::streamoff>(file_.tellg(), 0));
    return offset <= length && size <= length - offset;
  }

  std::ifstream file_;
  std::vector<ElfW(Phdr)> segments_;
};

/// As the compiler writes the functions' names (Itanium C++ ABI), up to their parameters.
constexpr std::pair<const char*, PluginRole> kRegistering[] = {
    {"_ZN3vir5roles17registerEstimatorE", PluginRole::estimator},
    {"_ZN3vir5roles18registerRendezvousE", PluginRole::rendezvous},
    {"_ZN3vir5roles14registerSensorE", PluginRole::sensor},
};

}  // namespace

PluginRoles rolesOfPlugin(const std::string& file) {
  const std::string names = ElfFile(file).names();
  PluginRoles roles;
  for (const auto& [symbol, role] : kRegistering) {
    if (names.find(symbol) != std::string::npos) roles.insert(role);
  }
  return roles.empty() ? kAllPluginRoles : roles;
}

}  // namespace vir::roles
