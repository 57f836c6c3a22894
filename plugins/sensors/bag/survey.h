#pragma once
/// A first look into a recording: topics, calibration, contrast.
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "frames.h"
#include "image_decoding.h"
#include "vir/bags/bag_reader.h"
#include "vir/bags/message_view.h"

namespace vir::bag {

/// Definitions by channel, each parsed once.
class Definitions {
 public:
  /// nullptr if there is none or it cannot be read; then `problem` says why.
  const bags::Definition* of(const bags::Channel& channel, std::string* problem = nullptr);

 private:
  struct Entry {
    /// Held, so that no other text can get the address that is the key.
    std::shared_ptr<const std::string> text;
    std::shared_ptr<const bags::Definition> definition;
    std::string problem;
  };
  std::map<std::tuple<const std::string*, std::string, int>, Entry> known_;
};

/// sensor_msgs/CameraInfo.
struct CameraInfo {
  int width = 0, height = 0;
  std::string model;
  std::vector<double> D, K, P;
  int binning = 1;
};

struct TopicInfo {
  std::string topic, type;
  /// Anchor and distance by the names of fields, of a type that is not known; else empty.
  std::vector<std::string> range_guess;
  bool speaks_of_ranges = false;  ///< its type or its own name, which nobody knows
  long count = 0;
  TimeNs first = 0, last = 0;  ///< received
  std::string frame;           ///< of the first message that has one
  std::string child_frame;     ///< of odometry and transforms
  std::string problem;         ///< why its messages cannot be read; empty: they can
  bool bare_vector = false;    ///< x, y, z right in the message, as programs on phones write it
  bags::Metadata metadata = {};
  bool camera = false;        ///< images of a kind that a camera gives
  bool real_numbers = false;  ///< their pixels are floats: thermal, or depth
  int width = 0, height = 0;  ///< [px]
  bool stamped = false;
  TimeNs lag = 0;  ///< received - header stamp, of the first message that has one

  double rate() const {
    return last > first ? static_cast<double>(count - 1) / toSeconds(last - first) : 0;
  }
};

struct Survey {
  std::map<std::string, TopicInfo> topics;
  std::map<std::string, CameraInfo> camera_infos;  ///< by their own topic
  std::map<std::string, LevelFinder> levels;       ///< by topic of images
  FrameTree frames;
  std::vector<std::string> damage;
  TimeNs first = 0, last = 0;  ///< received
  bool whole = false;          ///< the end was reached

  const TopicInfo* find(const std::string& topic) const;
};

/// Reads the first `seconds` [s] of the recording, or all of it if `seconds` <= 0, and further
/// until each topic of `wanted` has come. Throws bags::BagError if there is nothing to read.
Survey survey(const std::string& source, double seconds, const std::vector<std::string>& wanted);

/// A table of topics, types, rates.
std::string listing(const Survey& survey);

bool isImage(const std::string& type);

}  // namespace vir::bag
