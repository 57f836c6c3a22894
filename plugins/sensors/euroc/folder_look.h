#pragma once
/// What is in a folder that nobody laid out for us.
#include <map>
#include <string>
#include <vector>

#include "table_kind.h"

namespace vir::euroc {

struct Found {
  std::map<TableKind, std::vector<std::string>> tables;  ///< full names, shallow ones first
  std::vector<std::string> image_dirs;
  std::vector<std::string> videos;
  std::vector<std::string> yamls;
  std::vector<std::string> no_text;  ///< files of tables that are empty
  std::vector<std::string> unused;   ///< tables of numbers of no kind that is imported
};

/// By names, tables by their beginnings too; up to four folders deep.
Found lookAround(const std::string& source);

}  // namespace vir::euroc
