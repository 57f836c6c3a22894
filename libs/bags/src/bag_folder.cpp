#include "bag_folder.h"

#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>

#include "decompress.h"
#include "mcap_reader.h"
#include "sqlite_reader.h"

namespace vir::bags {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMetadata = "metadata.yaml";

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool isBagFile(const std::string& name) {
  for (const char* end : {".db3", ".mcap", ".db3.zstd", ".mcap.zstd", ".db3.zst", ".mcap.zst"}) {
    if (endsWith(name, end)) return true;
  }
  return false;
}

/// `a_10` behind `a_9`: numbers within names count as numbers.
bool before(const std::string& a, const std::string& b) {
  std::size_t i = 0, k = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && k < b.size()) {
    if (digit(a[i]) && digit(b[k])) {
      const std::size_t from_i = i, from_k = k;
      while (i < a.size() && digit(a[i])) ++i;
      while (k < b.size() && digit(b[k])) ++k;
      const std::string x = a.substr(from_i, i - from_i), y = b.substr(from_k, k - from_k);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a[i] != b[k]) {
      return a[i] < b[k];
    } else {
      ++i, ++k;
    }
  }
  return a.size() - i < b.size() - k;
}

/// Files as metadata.yaml lists them; what cannot be read there is said in `doubt`.
std::vector<std::string> listed(const std::string& folder, std::string* doubt) {
  std::vector<std::string> files;
  const fs::path path = fs::path(folder) / kMetadata;
  if (!fs::exists(path)) {
    *doubt = folder +
             ": has no metadata.yaml (the recording was not ended properly?); its files "
             "are taken in the order of their names";
    return files;
  }
  try {
    const YAML::Node root = YAML::LoadFile(path.string());
    for (const YAML::Node& file : root["rosbag2_bagfile_information"]["relative_file_paths"]) {
      // Some versions wrote the folder's name before it.
      files.push_back(fs::path(file.as<std::string>()).filename().string());
    }
  } catch (const std::exception& e) {
    files.clear();
    *doubt = path.string() + ": cannot be read (" + e.what() +
             "); the files of the folder are taken in the order of their names";
  }
  return files;
}

std::vector<std::string> found(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    const std::string name = it->path().filename().string();
    if (isBagFile(name)) files.push_back(name);
  }
  std::sort(files.begin(), files.end(), before);
  // Unpacked and packed beside each other is one recording.
  files.erase(std::remove_if(files.begin(), files.end(),
                             [&](const std::string& f) {
                               const std::size_t z = f.rfind(".zst");
                               return z != std::string::npos &&
                                      std::count(files.begin(), files.end(), f.substr(0, z)) > 0;
                             }),
              files.end());
  return files;
}

/// A file in the temporary folder that goes away with this.
class Unpacked {
 public:
  explicit Unpacked(const std::string& packed) {
    path_ = (fs::temp_directory_path() / "vir-bag-XXXXXX").string();
    const int fd = ::mkstemp(path_.data());
    if (fd < 0) throw BagError(path_ + ": no file can be made there; set TMPDIR to a folder");
    try {
      doubt_ = decompressFile(packed, fd);
    } catch (...) {
      ::close(fd);
      ::unlink(path_.c_str());
      throw;
    }
    ::close(fd);
  }
  ~Unpacked() { ::unlink(path_.c_str()); }
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;
  const std::string& path() const { return path_; }
  const std::string& doubt() const { return doubt_; }

 private:
  std::string path_, doubt_;
};

class PackedReader : public BagReader {
 public:
  explicit PackedReader(const std::string& path) : file_(path) {
    if (!file_.doubt().empty()) report(path + ": " + file_.doubt() + "; what comes before is used");
    inner_ = path.find(".mcap") != std::string::npos ? openMcap(InputFile(file_.path()))
                                                     : openSqlite(file_.path(), path);
  }
  bool next(BagMessage* message) override {
    if (inner_->next(message)) return true;
    if (!told_) {
      takeOver(*inner_);
    }
    told_ = true;
    return false;
  }
  double progress() const override { return inner_->progress(); }

 private:
  Unpacked file_;
  std::unique_ptr<BagReader> inner_;
  bool told_ = false;
};

class FolderReader : public BagReader {
 public:
  explicit FolderReader(std::string folder) : folder_(std::move(folder)) {
    std::string doubt;
    files_ = listed(folder_, &doubt);
    if (!doubt.empty()) report(doubt);
    const std::vector<std::string> there = found(folder_);
    for (std::string& f : files_) {
      // Named as it was before it was compressed, or the other way round.
      if (fs::exists(fs::path(folder_) / f)) continue;
      for (const std::string& t : there) {
        if (t.rfind(f + ".zst", 0) == 0 || f.rfind(t + ".zst", 0) == 0) f = t;
      }
    }
    if (files_.empty()) files_ = there;
    if (files_.empty()) {
      throw BagError(folder_ +
                     ": holds no .db3 or .mcap file; give the folder that `ros2 bag "
                     "record` wrote");
    }
  }

  bool next(BagMessage* message) override {
    while (at_ < files_.size()) {
      if (!reader_ && !open()) continue;
      if (reader_->next(message)) return true;
      takeOver(*reader_);
      // Channels live as long as the reader.
      used_.push_back(std::move(reader_));
      ++at_;
    }
    return false;
  }
  double progress() const override {
    const double inside = reader_ ? reader_->progress() : 0;
    return std::min(1.0, (static_cast<double>(at_) + inside) / static_cast<double>(files_.size()));
  }

 private:
  bool open() {
    const std::string path = (fs::path(folder_) / files_[at_]).string();
    try {
      reader_ = openBag(path);
      return true;
    } catch (const BagError& e) {
      report(std::string(e.what()) + "; this part of the recording is left out");
      if (files_.size() == 1) throw;
      ++at_;
      return false;
    }
  }

  std::string folder_;
  std::vector<std::string> files_;
  std::size_t at_ = 0;
  std::unique_ptr<BagReader> reader_;
  std::vector<std::unique_ptr<BagReader>> used_;
};

}  // namespace

bool isBagFolder(const std::string& folder) {
  std::error_code ec;
  if (!fs::is_directory(folder, ec)) return false;
  return !found(folder).empty();
}

std::unique_ptr<BagReader> openFolder(const std::string& folder) {
  return std::make_unique<FolderReader>(folder);
}

std::unique_ptr<BagReader> openPacked(const std::string& path) {
  return std::make_unique<PackedReader>(path);
}

}  // namespace vir::bags
