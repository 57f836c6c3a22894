#include "camera_choice.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <tuple>
#include <utility>

#include "vir/core/text.h"

namespace vir::bag {
namespace {

bool contains(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* w) { return text.find(w) != std::string::npos; });
}

/// The raw one of two that are the same; left or first camera before others.
int rank(const TopicInfo& t) {
  const std::string name = lowerCase(t.topic);
  int rank = t.type == "sensor_msgs/Image" ? 0 : 1;
  if (contains(name, {"left", "cam0", "camera0", "infra1", "cam_0"})) rank -= 2;
  // Floats may be depth, of which the name says nothing.
  if (t.real_numbers) rank += 8;
  if (contains(name, {"right", "cam1", "camera1", "infra2", "cam_1"})) rank += 2;
  return rank;
}

/// A word of a name, or (no text) a number or a side.
struct Word {
  std::string text;
  long number = 0;

  friend bool operator<(const Word& a, const Word& b) {
    return std::tie(a.text, a.number) < std::tie(b.text, b.number);
  }
  friend bool operator==(const Word& a, const Word& b) {
    return a.text == b.text && a.number == b.number;
  }
};

Word wordOf(const std::string& text) {
  if (text == "left") return {"", 0};
  if (text == "right") return {"", 1};
  if (std::isdigit(static_cast<unsigned char>(text[0])) == 0) return {text, 0};
  return {"", std::stol(text.substr(0, 9))};
}

/// What a topic's name says of the camera: `/cam0/image_rect/compressed` is that of `/cam0`, and
/// `/left_raw/image` that of `/left`.
std::vector<Word> wordsOf(const std::string& topic) {
  std::string stem = lowerCase(baseOf(topic));
  const std::size_t slash = stem.rfind('/');
  if (slash != std::string::npos && slash > 0 &&
      contains(stem.substr(slash), {"/image", "/img", "/color", "/mono"})) {
    stem.resize(slash);
  }
  std::vector<Word> out;
  std::string word;
  const auto close = [&] {
    const bool processing = word == "raw" || word == "rect" || word == "rectified" ||
                            word == "undistorted" || word == "resized" || word == "image";
    if (!word.empty() && !processing) out.push_back(wordOf(word));
    word.clear();
  };
  for (const char c : stem) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) == 0) {
      close();
      continue;
    }
    if (!word.empty() &&
        (std::isdigit(u) != 0) != (std::isdigit(static_cast<unsigned char>(word.back())) != 0)) {
      close();
    }
    word += c;
  }
  close();
  return out;
}

/// But for numbers and sides the same.
bool ofAKind(const std::vector<Word>& a, const std::vector<Word>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Word& x, const Word& y) { return x.text == y.text; });
}

struct Candidate {
  const TopicInfo* info = nullptr;
  std::vector<Word> words;
  bool named = false;  ///< by the calibration
};

bool isIn(const std::vector<std::string>& named, const std::string& topic) {
  return std::any_of(named.begin(), named.end(),
                     [&](const std::string& other) { return baseOf(other) == baseOf(topic); });
}

/// Two topics of one camera. Drivers may write the frame of the left camera to both images of a
/// pair: then their names tell.
bool sameCamera(const Candidate& a, const Candidate& b) {
  if (a.words == b.words) return true;
  return !a.info->frame.empty() && a.info->frame == b.info->frame && !ofAKind(a.words, b.words);
}

/// One topic for each camera, the best of all in front.
std::vector<Candidate> toldApart(const Survey& survey, const std::vector<std::string>& named,
                                 CameraChoice* out) {
  std::vector<Candidate> all, apart;
  for (const auto& [topic, info] : survey.topics) {
    if (isImage(info.type) && info.camera && !isNoPicture(info)) {
      all.push_back({&info, wordsOf(topic), isIn(named, topic)});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return a.named != b.named ? a.named : rank(*a.info) < rank(*b.info);
  });
  for (const Candidate& c : all) {
    if (c.info->real_numbers && !all.front().info->real_numbers) {
      out->left_out[c.info->topic] = "its pixels are floats, which may be depth";
      continue;
    }
    const auto same = std::find_if(apart.begin(), apart.end(),
                                   [&](const Candidate& other) { return sameCamera(c, other); });
    if (same == apart.end()) {
      apart.push_back(c);
    } else if (baseOf(same->info->topic) != baseOf(c.info->topic)) {
      out->left_out[c.info->topic] =
          "by its name or frame it is the camera of " + same->info->topic + " once more";
    }
  }
  return apart;
}

}  // namespace

std::string baseOf(const std::string& topic) {
  const std::string end = "/compressed";
  const bool compressed =
      topic.size() > end.size() && topic.compare(topic.size() - end.size(), end.size(), end) == 0;
  return compressed ? topic.substr(0, topic.size() - end.size()) : topic;
}

bool isNoPicture(const TopicInfo& t) {
  return contains(lowerCase(t.topic),
                  {"depth", "disparity", "confidence", "range_im", "xyz", "normals"});
}

CameraChoice chooseCameras(const Survey& survey, const std::vector<std::string>& named,
                           const Lacks& lacks, bool all_of_a_kind) {
  CameraChoice out;
  std::vector<Candidate> cameras = toldApart(survey, named, &out);
  if (cameras.empty()) return out;
  const std::vector<Word> kind = cameras.front().words;
  std::sort(cameras.begin(), cameras.end(), [&](const Candidate& a, const Candidate& b) {
    if (a.named != b.named) return a.named;
    const bool kin_a = ofAKind(a.words, kind), kin_b = ofAKind(b.words, kind);
    return kin_a != kin_b ? kin_a : a.words < b.words;
  });
  std::vector<std::string> topics;
  for (const Candidate& c : cameras) topics.push_back(c.info->topic);
  const std::vector<std::string> why = lacks(topics);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const TopicInfo& info = *cameras[i].info;
    const bool kin = all_of_a_kind && ofAKind(cameras[i].words, kind);
    if (i == 0 || why[i].empty() || kin) {
      out.taken.push_back(&info);
    } else {
      out.left_out[info.topic] = why[i];
    }
  }
  return out;
}

}  // namespace vir::bag
