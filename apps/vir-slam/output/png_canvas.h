#pragma once
/// A figure as pixels, for who cannot show SVG.
#include <string>

#include "vir/evaluation/figure.h"

namespace vir::app {

/// Writes a PNG twice as fine as the figure's px. Throws std::runtime_error if it cannot be
/// written.
void writePng(const evaluation::Figure& figure, const std::string& path);

}  // namespace vir::app
