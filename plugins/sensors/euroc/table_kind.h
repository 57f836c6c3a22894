#pragma once
/// What a table of numbers holds, by its header, its name and the size of its numbers.
#include <string>

namespace vir::euroc {

enum class TableKind { none, imu, gyro, accelerometer, range, images, poses, anchors };

/// For people: "IMU", "ranges", ...
const char* name(TableKind kind);

/// `path` below the folder that was named (`relative`): its folders' names count too.
TableKind kindOfTable(const std::string& path, const std::string& relative);

/// Do ending and name say that `path` may be a table?
bool mayBeTable(const std::string& path);

/// What a file is called after: an IMU, ranges or poses; else none.
TableKind kindByName(const std::string& relative);
/// Why a table holds nothing of a kind that its name stands for; may be empty.
std::string whyNotOfKind(const std::string& path, TableKind kind);

}  // namespace vir::euroc
