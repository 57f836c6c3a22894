#include "output/picture_file.h"

#include <filesystem>

#include "commands/commands.h"
#include "output/png_canvas.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace {

bool isPng(const std::string& path) { return std::filesystem::path(path).extension() == ".png"; }

}  // namespace

/// A plot under the name of another format would be opened by nothing.
void requirePicture(const std::string& option, const std::string& path) {
  if (isPng(path) || std::filesystem::path(path).extension() == ".svg") return;
  throw UsageError(option + " " + path +
                   ": a picture is written as .svg or .png; name one of these");
}

void writePicture(const evaluation::Figure& figure, const std::string& path) {
  if (isPng(path)) {
    writePng(figure, path);
  } else {
    results::writeTextFile(path, evaluation::toSvg(figure));
  }
}

}  // namespace vir::app
