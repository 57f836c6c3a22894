#pragma once
/// A bag as one stream of readings in time order.
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "anchor_places.h"
#include "bag_options.h"
#include "camera_setup.h"
#include "imu_pairing.h"
#include "problem_log.h"
#include "topic_choice.h"
#include "vir/tables/anchor_names.h"
#include "vir/types/imu_sample.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::bag {

/// An image as 8 bits, with bytes of its own.
struct ImageReading {
  std::size_t camera = 0;
  cv::Mat pixels;
  bags::Bytes file;  ///< PNG or JPEG of exactly these pixels; empty: there is none
  const char* extension = "";
};

/// A pose that another robot told, or that of an anchor when it was put down.
struct ToldPose {
  StampedPose pose;
  Mat3 covariance = Mat3::Zero();  ///< of the position [m^2]
};

struct Reading {
  TimeNs t = 0;
  int stream = 0;
  std::variant<ImuSample, Range, StampedPose, ImageReading, ToldPose> what;
  std::string label = {};  ///< of a further radio in the stream; empty: the stream's own
};

/// Opens the recording, chooses topics, and gives their readings. What is wrong with single
/// messages is counted in the log. Memory does not depend on the recording's length.
class BagRecording {
 public:
  /// Throws InputError or bags::BagError if nothing can be imported. `log` must outlive this.
  BagRecording(const BagOptions& options, ProblemLog* log);

  /// In order of time; at one stamp IMU, range, poses, image. What comes more than two seconds too
  /// late is handed out all the same, and counted. False at the end.
  bool next(Reading* reading);
  double progress() const;

  const std::vector<Stream>& streams() const { return choice_.streams; }
  const std::vector<CameraSetup>& cameras() const { return cameras_; }
  const CalibrationExtras& extras() const { return extras_; }
  const tables::AnchorNames& anchors() const { return anchors_; }
  /// Where the messages read so far say that the anchors are.
  const AnchorPlaces& anchorPlaces() const { return places_; }

 private:
  /// Of ranges of the stream `s` by this tag: the stream's own for the first that is heard.
  std::size_t antennaOf(const Stream& s, int index, const std::string& tag);
  struct Held {
    Reading reading;
    TimeNs received = 0;
    std::size_t bytes = 0;
  };

  void checkClocks(const Survey& survey) const;
  bool readOne();
  void noteLate(const bags::Channel& channel);
  void take(const bags::BagMessage& message, int index);
  TimeNs stampOf(const bags::MessageView& m, const bags::BagMessage& message, const Stream& s);
  void takeImu(const bags::MessageView& m, const Stream& s, TimeNs t, TimeNs received, int index);
  bool takeFile(const bags::MessageView& m, const Stream& s, TimeNs t, TimeNs received, int index);
  void takeImage(const bags::MessageView& m, const Stream& s, TimeNs t, TimeNs received, int index);
  void takePose(const bags::MessageView& m, const Stream& s, TimeNs t, TimeNs received, int index);
  void takeRanges(const bags::MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                  int index);
  void hold(Reading reading, TimeNs received, std::size_t bytes);
  bool mayGo() const;
  void tellDamage();
  std::string whereOf(const Stream& s, TimeNs t) const;

  BagOptions options_;
  ProblemLog* log_;
  Choice choice_;
  std::vector<CameraSetup> cameras_;
  std::vector<Levels> levels_;
  CalibrationExtras extras_;
  std::unique_ptr<bags::BagReader> reader_;
  Definitions definitions_;
  std::map<std::string, std::vector<int>> by_topic_;
  std::set<std::string> looked_at_;  // topics that were there in the beginning, or have been named
  std::set<std::string> warned_;
  ImuPairing pairing_;
  double acc_unit_ = 1, gyro_unit_ = 1;  ///< what one of them is [m/s^2], [rad/s]
  tables::AnchorNames anchors_;
  AnchorPlaces places_;
  std::map<std::pair<int, std::string>, std::size_t> antennas_;  // by stream and tag
  std::size_t next_antenna_ = 0;                                 // after those of the topics
  std::multimap<std::pair<TimeNs, int>, Held> held_;
  std::size_t held_bytes_ = 0;
  bool ended_ = false;
  TimeNs newest_ = 0, first_ = 0, last_out_ = INT64_MIN;
};

}  // namespace vir::bag
