#include "dialogue.h"

#include <algorithm>

namespace vir::uwb {
namespace {

constexpr double kFirstPatienceS = 2, kLastPatienceS = 30;
constexpr double kPromptS = 1.5;  // for the prompt to come
constexpr const char* kPrompt = "dwm>";

}  // namespace

void Dwm1001Dialogue::enter(Phase phase, double now_s, double for_s) {
  phase_ = phase;
  until_s_ = now_s + for_s;
  prompt_ = false;
}

void Dwm1001Dialogue::restart() {
  begun_ = engaged_ = false;
  tail_.clear();
}

void Dwm1001Dialogue::hear(const std::uint8_t* bytes, std::size_t size) {
  tail_.append(reinterpret_cast<const char*>(bytes), size);
  if (tail_.find(kPrompt) != std::string::npos) prompt_ = true;
  if (tail_.size() > 3) tail_.erase(0, tail_.size() - 3);
}

std::string Dwm1001Dialogue::step(double now_s, long messages) {
  if (!begun_ || messages != messages_) {
    if (!begun_) patience_s_ = kFirstPatienceS;
    begun_ = true;
    messages_ = messages;
    enter(Phase::listening, now_s, patience_s_);
    return {};
  }
  if (phase_ == Phase::waking && prompt_) {
    enter(Phase::commanded, now_s, patience_s_);
    patience_s_ = std::min(2 * patience_s_, kLastPatienceS);
    return "lec\r";
  }
  if (now_s < until_s_) return {};
  if (phase_ == Phase::waking) {
    patience_s_ = std::min(2 * patience_s_, kLastPatienceS);
    enter(Phase::listening, now_s, patience_s_);
    return {};
  }
  enter(Phase::waking, now_s, kPromptS);
  engaged_ = true;
  return "\r\r";
}

std::string TlvPolling::step(double now_s) {
  if (now_s < next_s_) return {};
  next_s_ = now_s + period_s_;
  return std::string("\x0C\x00", 2);
}

}  // namespace vir::uwb
