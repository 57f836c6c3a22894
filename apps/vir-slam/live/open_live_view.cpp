#include <cstdlib>
#include <stdexcept>

#include "live/live_view.h"
#include "live/program_module.h"

namespace vir::app {

std::unique_ptr<LiveView> openLiveView() {
  // MRPT would wait for seconds and then go on with a window that is none.
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') throw std::runtime_error("there is no display");
  auto* open =
      reinterpret_cast<LiveView* (*)()>(functionOf("libvir_live_view.so", "virOpenLiveView"));
  return std::unique_ptr<LiveView>(open());
}

std::unique_ptr<LiveView> openVideoView(const std::string& file, double speed) {
  auto* open = reinterpret_cast<LiveView* (*)(const std::string&, double)>(
      functionOf("libvir_video_view.so", "virOpenVideoView"));
  return std::unique_ptr<LiveView>(open(file, speed));
}

}  // namespace vir::app
