#include "vir/rawlog/rawlog_reader.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImages.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <filesystem>
#include <new>
#include <stdexcept>

#include "gz_archive.h"
#include "image_files.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/plausible.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir/rawlog/stereo_images.h"

namespace vir::rawlog {
namespace fs = std::filesystem;
namespace {

std::string findImageFolder(const std::string& rawlog) {
  const fs::path absolute = fs::absolute(rawlog);
  const std::string own = RawlogWriter::imageFolderOf(absolute.string());
  for (const fs::path& folder : {fs::path(own), absolute.parent_path() / "Images"}) {
    std::error_code ignored;
    if (fs::is_directory(folder, ignored)) return folder.string();
  }
  return {};
}

}  // namespace

RawlogReader::RawlogReader(const std::string& path) : path_(path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw std::runtime_error("there is no such rawlog: " + path);
  if (fs::is_directory(path, error)) {
    throw std::runtime_error("not a rawlog but a folder: " + path);
  }
  file_bytes_ = static_cast<double>(fs::file_size(path, error));
  if (!error && file_bytes_ == 0) throw std::runtime_error("the rawlog is empty: " + path);
  image_folder_ = findImageFolder(path);
  archive_ = GzArchive::forReading(path);
}

RawlogReader::~RawlogReader() = default;

mrpt::obs::CObservation::Ptr RawlogReader::next() {
  while (queue_.empty() && archive_) readOne();
  if (queue_.empty()) return nullptr;
  auto observation = std::move(queue_.front());
  queue_.pop_front();
  return observation;
}

void RawlogReader::readOne() {
  try {
    const auto object = archive_->readBounded();
    ++objects_;
    if (auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object)) {
      take(observation);
    } else if (auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      for (auto& member : *frame) take(member);
    } else {
      ++skipped_;
    }
  } catch (const mrpt::serialization::CExceptionEOF&) {
    // A read error between two objects looks like the end to MRPT; zlib knows better.
    stop(archive_->streamError());
  } catch (const std::bad_alloc&) {
    stop("a size in it is larger than what the file can hold");
  } catch (const std::length_error&) {
    stop("a size in it is larger than what the file can hold");
  } catch (const std::exception& e) {
    const std::string stream = archive_->streamError();
    stop(stream.empty() ? shortReason(e) : stream);
  }
}

void RawlogReader::take(const mrpt::obs::CObservation::Ptr& observation) {
  using mrpt::obs::CObservationImage;
  using mrpt::obs::CObservationStereoImages;
  if (!observation) return;
  if (auto pair = std::dynamic_pointer_cast<CObservationStereoImages>(observation)) {
    return takePair(*pair);
  }
  const std::string why = implausible(*observation);
  if (!why.empty()) return leaveOut(observation->sensorLabel, why);
  if (auto image = std::dynamic_pointer_cast<CObservationImage>(observation)) {
    placeImage(&image->image);
  }
  queue_.push_back(observation);
}

void RawlogReader::takePair(const mrpt::obs::CObservationStereoImages& pair) {
  const PairLabels labels = pair_names_.of(pair.sensorLabel);
  try {
    for (const auto& image : imagesOf(pair, labels)) take(image);
  } catch (const std::invalid_argument& e) {
    leaveOut(labels.left, e.what());
  }
}

void RawlogReader::leaveOut(const std::string& label, const std::string& why) {
  ++implausible_[label + ": " + why];
  ++left_out_[label];
}

void RawlogReader::placeImage(mrpt::img::CImage* image) {
  if (!image->isExternallyStored()) return;
  const std::string name = image->getExternalStorageFile();
  const ImageFile file = imageFileOf(name, path_, image_folder_);
  // MRPT resolves a relative name against one folder for the whole process.
  if (file.refused.empty()) {
    if (!file.path.empty()) image->setExternalStorage(file.path);
    return;
  }
  if (refused_images_++ == 0) first_refused_ = file.refused;
  image->setExternalStorage(refusedName(image_folder_));
}

std::string RawlogReader::refusals() const {
  std::string text;
  if (refused_images_ > 0) {
    text = std::to_string(refused_images_) + " images were refused: " + first_refused_;
  }
  for (const auto& [why, count] : implausible_) {
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " observations left out of " + why;
  }
  return text.empty() ? text : path_ + ": " + text;
}

void RawlogReader::stop(const std::string& reason) {
  archive_.reset();
  if (reason.empty()) return;
  damage_ =
      path_ + " is damaged or cut off after " + std::to_string(objects_) + " objects: " + reason;
}

double RawlogReader::progress() const {
  if (!archive_ || file_bytes_ <= 0) return 1;
  return static_cast<double>(archive_->compressedPosition()) / file_bytes_;
}

}  // namespace vir::rawlog
