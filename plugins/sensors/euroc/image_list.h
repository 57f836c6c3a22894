#pragma once
/// The images of a camera: which there are, when they were taken.
#include <memory>
#include <string>
#include <vector>

#include "folder.h"
#include "problem_log.h"
#include "readers.h"

namespace vir::euroc {

/// By the camera's list; by the stamps in the names of the files where there is none; and in the
/// order of the names where the list has stamps only, as many as there are files. Throws InputError
/// where none of this tells a time.
std::unique_ptr<RowStream<ImageRow>> openImages(const CameraFiles& camera, ProblemLog* log);

/// Files in `dir`, or in `data` below it, that are images by their names; sorted, numbers by value.
std::vector<std::string> imagesIn(const std::string& dir);

/// By its ending.
bool isImageFile(const std::string& path);

}  // namespace vir::euroc
