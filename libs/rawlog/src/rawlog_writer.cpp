#include "vir/rawlog/rawlog_writer.h"

#include <filesystem>
#include <stdexcept>

#include "gz_archive.h"

namespace vir::rawlog {
namespace fs = std::filesystem;
namespace {

std::string partOf(const std::string& path) { return path + ".part"; }

}  // namespace

RawlogWriter::RawlogWriter(const std::string& path, int compression) : path_(path) {
  const fs::path target(path);
  if (path.empty()) throw std::runtime_error("cannot write a rawlog: no file name given");
  if (fs::is_directory(target)) {
    throw std::runtime_error("cannot write " + path + ": it is a folder");
  }
  std::error_code error;
  if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
  if (error) {
    throw std::runtime_error("cannot create the folder " + target.parent_path().string() + ": " +
                             error.message());
  }
  archive_ = GzArchive::forWriting(partOf(path), compression);
}

RawlogWriter::~RawlogWriter() {
  if (!archive_) return;
  archive_.reset();
  std::error_code ignored;
  fs::remove(partOf(path_), ignored);
}

void RawlogWriter::write(const mrpt::obs::CObservation& observation) {
  if (!archive_) throw std::logic_error("RawlogWriter::write after finish: " + path_);
  archive_->WriteObject(observation);
  ++written_;
}

void RawlogWriter::finish() {
  if (!archive_) return;
  const auto archive = std::move(archive_);
  std::error_code error;
  try {
    archive->close();
  } catch (const std::exception&) {
    fs::remove(partOf(path_), error);
    throw;
  }
  fs::rename(partOf(path_), path_, error);
  if (error) {
    throw std::runtime_error("cannot rename " + partOf(path_) + " to " + path_ + ": " +
                             error.message());
  }
}

std::string RawlogWriter::imageFolder() const { return imageFolderOf(path_); }

std::string RawlogWriter::imageFolderOf(const std::string& rawlog_path) {
  std::string stem = rawlog_path;
  for (const std::string suffix : {".gz", ".rawlog"}) {
    if (stem.size() > suffix.size() &&
        stem.compare(stem.size() - suffix.size(), suffix.size(), suffix) == 0) {
      stem.resize(stem.size() - suffix.size());
    }
  }
  return stem + "_Images";
}

}  // namespace vir::rawlog
