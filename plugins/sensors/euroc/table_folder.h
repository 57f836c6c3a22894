#pragma once
/// Which tables and images of any folder are what.
#include <string>

#include "euroc_options.h"
#include "folder.h"

namespace vir::euroc {

/// The folder itself, or that of a video.
std::string folderOfSource(const std::string& source);

/// Does a folder that is not EuRoC's hold tables of an IMU or of ranges, or a video and tables; or
/// is it a video? Looks at names and at the beginnings of files.
bool isTableFolder(const std::string& source);

/// By `topics` where a role is named there, else by headers, names and numbers; what else is there
/// is noted. Throws InputError where nothing fits or a named file is missing.
Folder findTables(const EurocOptions& options);

/// The tables and image folders that are there, and what they are taken for, for people.
std::string listTables(const std::string& source);

}  // namespace vir::euroc
