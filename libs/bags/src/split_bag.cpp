#include "split_bag.h"

#include <algorithm>
#include <filesystem>
#include <vector>

namespace vir::bags {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostParts = 512;
constexpr TimeNs kTogether = 60'000'000'000;

std::vector<std::string> bagsIn(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    // `.bag.active` is what a recorder that was killed leaves behind.
    const std::string name = it->path().filename().string();
    const bool active = name.size() > 11 && name.compare(name.size() - 11, 11, ".bag.active") == 0;
    if (it->path().extension() != ".bag" && !active) continue;
    if (bagKindOf(it->path().string()) == BagKind::ros1) files.push_back(it->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string withoutDigits(const std::string& path) {
  std::string out;
  for (const char c : fs::path(path).filename().string()) {
    if (c < '0' || c > '9') out += c;
  }
  return out.substr(0, out.find(".bag"));
}

/// A part with its next message.
struct Part {
  std::string path;
  std::unique_ptr<BagReader> reader;
  BagMessage message;
  bool has_message = false;
};

class SplitReader : public BagReader {
 public:
  explicit SplitReader(const std::string& folder) {
    const std::vector<std::string> files = bagsIn(folder);
    if (files.size() > kMostParts) {
      throw BagError(folder + ": holds more than " + std::to_string(kMostParts) + " bags");
    }
    for (const std::string& file : files) open(file);
    if (parts_.empty()) throw BagError(folder + ": none of its bags can be read");
    requireOneRecording(folder);
    if (parts_.size() > 1) {
      report(folder + ": " + std::to_string(parts_.size()) + " bags read as one recording");
    }
  }

  bool next(BagMessage* message) override {
    // What was given out last may be used until now.
    if (last_ != nullptr) advance(last_);
    last_ = nullptr;
    for (Part& p : parts_) {
      if (!p.has_message) continue;
      if (last_ == nullptr || p.message.received < last_->message.received) last_ = &p;
    }
    if (last_ == nullptr) return false;
    *message = last_->message;
    return true;
  }

  double progress() const override {
    double sum = 0;
    for (const Part& p : parts_) sum += p.has_message ? p.reader->progress() : 1;
    return sum / static_cast<double>(parts_.size());
  }

 private:
  void open(const std::string& path) {
    Part part;
    part.path = path;
    try {
      part.reader = openBag(path);
    } catch (const BagError& e) {
      report(std::string(e.what()) + "; this part of the recording is left out");
      return;
    }
    advance(&part);
    parts_.push_back(std::move(part));
  }

  void advance(Part* p) {
    p->has_message = p->reader->next(&p->message);
    if (p->has_message) return;
    takeOver(*p->reader);
  }

  void requireOneRecording(const std::string& folder) const {
    const Part* first = nullptr;
    bool same_name = true, together = true;
    for (const Part& p : parts_) {
      same_name = same_name && withoutDigits(p.path) == withoutDigits(parts_.front().path);
      if (!p.has_message) continue;
      if (first == nullptr) first = &p;
      const TimeNs apart = p.message.received - first->message.received;
      together = together && apart < kTogether && apart > -kTogether;
    }
    if (same_name || together) return;
    std::string names;
    for (const Part& p : parts_) {
      names += (names.empty() ? "" : ", ") + fs::path(p.path).filename().string();
    }
    throw BagError(folder + ": holds bags of several recordings, going by their names and times (" +
                   names + "); give one of them");
  }

  std::vector<Part> parts_;
  Part* last_ = nullptr;
};

}  // namespace

bool isSplitBag(const std::string& folder) {
  std::error_code ec;
  return fs::is_directory(folder, ec) && !bagsIn(folder).empty();
}

std::unique_ptr<BagReader> openSplitBag(const std::string& folder) {
  return std::make_unique<SplitReader>(folder);
}

}  // namespace vir::bags
