#include "vir/rawlog/live_recording.h"

#include <fcntl.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "gz_archive.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::rawlog {
namespace fs = std::filesystem;
namespace {

using mrpt::obs::CObservationImage;

constexpr const char* kSuffix = ".rawlog";

std::string stemOf(const std::string& path) {
  const std::string suffix = kSuffix;
  if (path.size() <= suffix.size() ||
      path.compare(path.size() - suffix.size(), suffix.size(), suffix) != 0) {
    throw std::runtime_error("cannot record to " + path + ": the name must end in .rawlog");
  }
  return path.substr(0, path.size() - suffix.size());
}

void removeIfEmpty(const std::string& folder) {
  std::error_code ignored;
  if (fs::is_empty(folder, ignored)) fs::remove(folder, ignored);
}

}  // namespace

void describe(OptionVisitor& v, LiveRecordingOptions& o) {
  v.choice("images", o.images, {"jpg", "png", "embed"}, "files beside the rawlog, or inside it");
  v.value("jpeg_quality", o.jpeg_quality, {1, 100}, "of images = jpg");
  v.value("compression", o.compression, {0, 9}, "of the rawlog itself; 0 = none");
  v.value("flush_s", o.flush_s, {0.01, 10}, "what is younger can be lost when the power goes");
  v.value("split_mb", o.split_mb, {0, 1e9},
          "a new file beyond this size, images not counted; 0 = never");
  v.value("split_s", o.split_s, {0, 1e9}, "a new file after so long; 0 = never");
}

/// One rawlog and its folder of images.
struct LiveRecording::File {
  explicit File(const std::string& path, int level)
      : archive(GzArchive::forRecording(path, level)) {}
  std::unique_ptr<GzArchive> archive;
  std::string images;
  TimeNs first = 0, last = 0;
  std::size_t count = 0;
};

/// Asks for the data to go to the disk in a thread of its own: that can take long.
class LiveRecording::DiskSync {
 public:
  explicit DiskSync(const std::string& folder)
      : handle_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)),
        thread_([this] { work(); }) {}
  ~DiskSync() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    thread_.join();
    if (handle_ >= 0) ::close(handle_);
  }
  void request() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      wanted_ = true;
    }
    wake_.notify_all();
  }

 private:
  void work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stop_ || wanted_; });
      if (!wanted_) return;
      wanted_ = false;
      lock.unlock();
      // The images as well, so the whole file system; errors show when writing.
      if (handle_ >= 0) syncfs(handle_);
      lock.lock();
    }
  }

  int handle_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false, wanted_ = false;
  std::thread thread_;
};

LiveRecording::LiveRecording(const std::string& path, const LiveRecordingOptions& options)
    : stem_(stemOf(path)), options_(options), images_inside_(options.images == "embed") {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  requireNew(path);
  sync_ = std::make_unique<DiskSync>(folder.string());
  open();  // last: what fails before leaves no file
}

LiveRecording::~LiveRecording() {
  try {
    close();
  } catch (const std::exception&) {  // reported by whoever called write() or close()
  }
}

void LiveRecording::requireNew(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  const std::string name = fs::path(stemOf(path)).filename().string();
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(folder.empty() ? fs::path(".") : folder, error)) {
    const std::string taken = entry.path().filename().string();
    if (taken.compare(0, name.size(), name) != 0) continue;
    const std::string rest = taken.substr(name.size());
    const bool part =
        rest.compare(0, 5, "_part") == 0 && rest.size() > 5 && rest[5] >= '0' && rest[5] <= '9';
    const bool late = rest == std::string("_late") + kSuffix || rest == "_late_Images";
    if (!part && !late && rest != kSuffix && rest != "_Images") continue;
    throw std::runtime_error("cannot record to " + path + ": " + entry.path().string() +
                             " exists already and is not overwritten");
  }
}

/// What was taken and then cut off is not there.
void LiveRecording::forgetCutOff() {
  if (file_) written_ -= file_->archive->takeCutOff();
  if (aside_) aside_count_ -= aside_->archive->takeCutOff();
}

std::string LiveRecording::asidePath() const { return stem_ + "_late" + kSuffix; }

void LiveRecording::open() {
  const std::size_t number = parts_.size() + 1;
  const std::string stem = number == 1 ? stem_ : stem_ + "_part" + std::to_string(number);
  file_ = std::make_unique<File>(stem + kSuffix, options_.compression);
  file_->images = stem + "_Images";
  parts_.push_back(stem + kSuffix);
}

bool LiveRecording::partIsFull(TimeNs t) const {
  if (file_->count == 0) return false;
  if (options_.split_s > 0 && toSeconds(t - file_->first) >= options_.split_s) return true;
  return options_.split_mb > 0 &&
         static_cast<double>(file_->archive->bytesWritten()) >= options_.split_mb * 1e6;
}

void LiveRecording::write(const mrpt::obs::CObservation& observation, bool in_order) {
  try {
    writeInto(observation, in_order);
  } catch (...) {
    forgetCutOff();
    throw;
  }
}

void LiveRecording::writeInto(const mrpt::obs::CObservation& observation, bool in_order) {
  if (!file_) throw std::runtime_error("the recording " + stem_ + kSuffix + " is closed");
  if (!in_order) {
    if (!aside_) {
      aside_ = std::make_unique<File>(asidePath(), options_.compression);
      aside_->images = stem_ + "_late_Images";
    }
    writeTo(*aside_, observation);
    ++aside_count_;
    return;
  }
  const TimeNs t = fromMrptTime(observation.timestamp);
  if (partIsFull(t)) {
    file_->archive->close();
    open();
  }
  if (file_->count++ == 0) file_->first = t;
  writeTo(*file_, observation);
  ++written_;
}

void LiveRecording::writeTo(File& file, const mrpt::obs::CObservation& observation) {
  const auto* image = dynamic_cast<const CObservationImage*>(&observation);
  if (image == nullptr || (images_inside_ && !image->image.isExternallyStored())) {
    file.archive->writeWhole(observation);
    return;
  }
  CObservationImage copy(*image);  // pixels are shared
  if (images_inside_) {
    copy.image = copy.image.makeDeepCopy();
    copy.image.unload();
    file.archive->writeWhole(copy);
    return;
  }
  fs::create_directories(file.images);
  const std::string stamp = std::to_string(fromMrptTime(image->timestamp));
  const std::string stem =
      (image->sensorLabel.empty() ? "image" : image->sensorLabel) + "_" + stamp;
  std::string name;
  if (image->image.isExternallyStored()) {
    const fs::path source = image->image.getExternalStorageFileAbsolutePath();
    name = stem + source.extension().string();
    const fs::path to = fs::path(file.images) / name;
    std::error_code error, ignored;
    if (!fs::copy_file(source, to, fs::copy_options::overwrite_existing, error)) {
      fs::remove(to, ignored);  // what there is of it
      throw std::runtime_error("cannot write " + to.string() + ": " + error.message());
    }
  } else {
    name = stem + "." + options_.images;
    if (!image->image.saveToFile(file.images + "/" + name, options_.jpeg_quality)) {
      std::error_code ignored;
      fs::remove(fs::path(file.images) / name, ignored);  // what there is of it
      throw std::runtime_error("cannot write " + file.images + "/" + name);
    }
  }
  copy.image.setExternalStorage(name);
  file.archive->writeWhole(copy);
}

void LiveRecording::flush() {
  try {
    for (File* file : {file_.get(), aside_.get()}) {
      if (file != nullptr) file->archive->flush();
    }
  } catch (...) {
    forgetCutOff();
    throw;
  }
  sync_->request();
}

/// A recording without a byte would only stand in the way of the next one.
void LiveRecording::forgetEmptyFile() {
  std::error_code error;
  if (parts_.empty() || !fs::is_empty(parts_.back(), error) || error) return;
  if (fs::remove(parts_.back(), error)) parts_.pop_back();
}

void LiveRecording::close() {
  for (std::unique_ptr<File>* file : {&file_, &aside_}) {
    if (!*file) continue;
    try {
      (*file)->archive->close();
    } catch (...) {
      forgetCutOff();
      file->reset();
      forgetEmptyFile();
      throw;
    }
    removeIfEmpty((*file)->images);
    file->reset();
  }
  forgetEmptyFile();
  if (sync_) sync_->request();
  sync_.reset();  // waits
}

}  // namespace vir::rawlog
