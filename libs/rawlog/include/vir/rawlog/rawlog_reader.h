#pragma once
#include <mrpt/img/CImage.h>
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "vir/rawlog/pair_names.h"

namespace mrpt::obs {
class CObservationStereoImages;
}

namespace vir::rawlog {

class GzArchive;

/// Whether images may lie outside the folder of their recording, for all that is read from then on:
/// no, unless the user says that the recording can be trusted.
void allowImagesElsewhere(bool allowed);

/// Reads a rawlog from front to back, one object at a time. Members of sensory frames come out one
/// by one, pairs of images (CObservationStereoImages) as the images of two cameras
/// (stereo_images.h). External images are looked for in `<name>_Images` beside the rawlog (else
/// `Images`); their paths are made absolute, so that several rawlogs can be read in one process.
class RawlogReader {
 public:
  /// Throws std::runtime_error naming file and reason if the file is missing, a folder, empty or
  /// cannot be opened.
  explicit RawlogReader(const std::string& path);
  ~RawlogReader();

  /// The next observation, or nullptr at the end. A damaged file ends where the damage starts:
  /// then damage() says so; everything before it has come out intact.
  mrpt::obs::CObservation::Ptr next();

  /// Empty, or what is wrong with the file and how many objects were read before.
  const std::string& damage() const { return damage_; }
  /// Empty, or how many images were refused and why the first one: its name leads out of the
  /// recording's folder, or to something that is no file. Such an observation comes out all the
  /// same; its image cannot be loaded. And how many observations were left out because they cannot
  /// be true (plausible.h).
  std::string refusals() const;
  /// Observations that were left out because they cannot be true, by label.
  const std::map<std::string, long>& leftOut() const { return left_out_; }
  /// Objects read from the file.
  std::size_t objects() const { return objects_; }
  /// Objects that are neither observations nor sensory frames.
  std::size_t skipped() const { return skipped_; }
  /// Part of the file read, 0..1.
  double progress() const;
  /// Where external images are looked for; empty if there is no such folder.
  const std::string& imageFolder() const { return image_folder_; }

 private:
  void readOne();
  void placeImage(mrpt::img::CImage* image);
  void take(const mrpt::obs::CObservation::Ptr& observation);
  void takePair(const mrpt::obs::CObservationStereoImages& pair);
  void leaveOut(const std::string& label, const std::string& why);
  void stop(const std::string& reason);

  PairNames pair_names_;
  std::map<std::string, std::size_t> implausible_;
  std::map<std::string, long> left_out_;
  std::string path_, image_folder_, damage_, first_refused_;
  std::unique_ptr<GzArchive> archive_;
  std::deque<mrpt::obs::CObservation::Ptr> queue_;
  double file_bytes_ = 0;
  std::size_t objects_ = 0, skipped_ = 0, refused_images_ = 0;
};

}  // namespace vir::rawlog
