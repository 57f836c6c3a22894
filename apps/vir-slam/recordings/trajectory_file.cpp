#include "recordings/trajectory_file.h"

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "commands/commands.h"
#include "output/console.h"
#include "vir/core/text_stream.h"
#include "vir/evaluation/leaps.h"

namespace vir::app {
namespace {

/// A rawlog, a bag, a picture.
bool isText(std::istream* in) {
  char first[512];
  in->read(first, sizeof first);
  const std::string read(first, static_cast<std::size_t>(in->gcount()));
  in->clear();
  in->seekg(0);
  return read.find('\0') == std::string::npos && read.compare(0, 2, "\x1F\x8B") != 0;
}

}  // namespace

Trajectory readTrajectoryFile(const std::string& given, const std::string& what,
                              evaluation::ReadReport* report) {
  // Of a run's folder its poses are meant.
  const std::filesystem::path inside = std::filesystem::path(given) / "trajectory.tum";
  const std::string path = std::filesystem::is_regular_file(inside) ? inside.string() : given;
  // A run that was lost leaves one without a pose; others are evaluated all the same.
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error) && std::filesystem::is_empty(path, error)) {
    std::fprintf(stderr, "%s: is empty\n", path.c_str());
    return {};
  }
  requireFile(path, what);
  TextStream in(path);
  if (!in) throw UsageError("cannot read the " + what + " " + path);
  if (!isText(&in)) {
    throw UsageError(path +
                     " is no table of poses (it is no text); poses in a rawlog become tables by: "
                     "vir-slam export FILE.rawlog --format tum --out FOLDER");
  }
  const Trajectory trajectory = evaluation::readTrajectory(in, report);
  const evaluation::ReadReport& r = *report;
  if (r.skipped() > 0) {
    std::fprintf(stderr,
                 "%s: %ld lines skipped (%ld malformed, %ld not finite, %ld without an "
                 "attitude, %ld with a repeated stamp)\n",
                 path.c_str(), r.skipped(), r.malformed, r.not_finite, r.zero_quaternions,
                 r.repeated);
    for (const std::string& message : r.messages) {
      std::fprintf(stderr, "  %s:%s\n", path.c_str(), printable(message).c_str());
    }
  }
  for (const std::string& note : r.notes) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), printable(note).c_str());
  }
  if (r.out_of_order > 0) {
    std::fprintf(stderr, "%s: %ld poses were out of order in time and have been sorted\n",
                 path.c_str(), r.out_of_order);
  }
  if (r.quaternions_normalised > 0) {
    std::fprintf(stderr, "%s: %ld quaternions were not of unit length and have been normalised\n",
                 path.c_str(), r.quaternions_normalised);
  }
  return trajectory;
}

std::vector<TimeNs> readImageStamps(const std::string& path) {
  requireFile(path, "list of images");
  TextStream in(path);
  std::vector<TimeNs> images = evaluation::readStamps(in);
  if (images.empty()) throw UsageError("no stamp in ns begins a line of " + path);
  return images;
}

Trajectory readReferenceFile(const std::string& path, evaluation::ReadReport* read,
                             long* left_out) {
  Trajectory out =
      evaluation::withoutLeaps(readTrajectoryFile(path, "reference trajectory", read), left_out);
  if (*left_out > 0) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), evaluation::describeLeaps(*left_out).c_str());
  }
  return out;
}

}  // namespace vir::app
