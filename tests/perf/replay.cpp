#include "replay.h"

#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "bias_model_file.h"
#include "hand_over.h"
#include "vir/core/stage_timer.h"
#include "vir/core/time_bounds.h"
#include "vir/rawlog/anchor_ranges.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/ordered_reader.h"
#include "vir/rawlog/range_differences.h"
#include "vir/roles/range_labels.h"

namespace vir::tool {
namespace {

using estimator::BackEnd;
using estimator::Feedback;
using estimator::FrontEnd;
using estimator::HandOver;
using estimator::Packet;

bool sameTracks(const Packet& a, const Packet& b) {
  const auto& x = a.frame.features;
  const auto& y = b.frame.features;
  return a.kind == b.kind && a.stamp == b.stamp && x.size() == y.size() &&
         std::equal(x.begin(), x.end(), y.begin(),
                    [](const auto& f, const auto& g) { return f.id == g.id && f.px == g.px; });
}

bool sameState(const StateEstimate& a, const StateEstimate& b) {
  return a.t_image == b.t_image && a.valid == b.valid && a.keyframe == b.keyframe &&
         a.state.T_W_B.p == b.state.T_W_B.p && a.state.T_W_B.q.coeffs() == b.state.T_W_B.q.coeffs();
}

[[noreturn]] void differs(const char* half, TimeNs stamp) {
  throw std::runtime_error(std::string("the ") + half + " alone does not what it did in the run: " +
                           "image of " + std::to_string(stamp) + " ns");
}

}  // namespace

Replay::Replay(std::string rawlog, VirSettings settings)
    : rawlog_(std::move(rawlog)),
      settings_(std::move(settings)),
      config_(withFiles(settings_.config)),
      calibration_(rawlog::calibrationIn(rawlog_, settings_.camera_label)) {
  config_.validate();
}

void Replay::play(FrontEnd* front_end, std::map<TimeNs, double>* decode_ms,
                  std::map<std::string, long>* others) const {
  front_end->setCamera(calibration_.camera, calibration_.T_B_C);
  rawlog::OrderedReader input(rawlog_);
  while (const auto o = input.next()) {
    if (const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(o.get())) {
      if (image->sensorLabel != settings_.camera_label) {
        ++(*others)[image->sensorLabel];
        continue;
      }
      estimator::WaitingImage waiting;
      double ms = 0;
      {
        StageTimer timer(&ms);
        const auto gray = rawlog::grayImageOf(*image);
        waiting.t = gray->t;
        waiting.gray = gray->pixels;
      }
      if (!isStamp(waiting.t)) continue;
      (*decode_ms)[waiting.t] = ms;
      front_end->addImage(std::move(waiting));
    } else if (o->sensorLabel == settings_.imu_label) {
      const auto sample = rawlog::imuSampleOf(*o);
      if (sample && isStamp(sample->t)) front_end->addImu(*sample);
    } else if (const auto anchor = rawlog::deployedAnchorOf(*o)) {
      front_end->addDeployedAnchor(*anchor);
    } else if (config_.ranges.use) {
      std::vector<Range> ranges = rawlog::rangeDifferencesOf(*o);
      if (roles::isAmong(o->sensorLabel, settings_.range_label)) ranges = rawlog::rangesOf(*o);
      for (const Range& r : ranges) {
        if (isStamp(r.t)) front_end->addRange(r);
      }
      for (const AnchorRange& r : rawlog::anchorRangesOf(*o)) front_end->addAnchorRange(r);
    }
  }
  front_end->finish();
}

const Replayed& Replay::run() {
  run_ = {};
  BackEnd back_end(config_, {});
  back_end.setCamera(calibration_.camera, calibration_.T_B_C);
  HandOver hand_over([&](Packet packet) { return back_end.process(std::move(packet)); },
                     config_.pipelined ? 1 : 0);
  FrontEnd front_end(
      config_,
      [&](long* covered) {
        run_.told.push_back(hand_over.ask(covered));
        return run_.told.back();
      },
      [&](Packet packet) {
        run_.packets.push_back(packet);
        hand_over.give(std::move(packet));
      });
  std::map<TimeNs, double> decode_ms;
  play(&front_end, &decode_ms, &run_.other_images);
  run_.states = std::move(back_end.results);
  return run_;
}

void Replay::frontEnd(const std::function<void(const Packet&, double)>& each) const {
  std::size_t asked = 0, sent = 0;
  std::map<TimeNs, double> decode_ms;
  std::map<std::string, long> others;
  FrontEnd front_end(
      config_,
      [&](long* covered) {
        if (asked >= run_.told.size()) throw std::runtime_error("more images than in the run");
        *covered = run_.packets[sent].feedback;
        return run_.told[asked++];
      },
      [&](const Packet& packet) {
        if (!sameTracks(packet, run_.packets[sent++])) differs("front end", packet.stamp);
        each(packet, decode_ms[packet.stamp]);
      });
  play(&front_end, &decode_ms, &others);
}

void Replay::backEnd(const std::function<void(const StateEstimate&, double)>& each) const {
  BackEnd back_end(config_, {});
  back_end.setCamera(calibration_.camera, calibration_.T_B_C);
  std::size_t n = 0;
  for (const Packet& original : run_.packets) {
    Packet packet = original;
    double ms = 0;
    {
      StageTimer timer(&ms);
      back_end.process(std::move(packet));
    }
    for (const StateEstimate& state : std::exchange(back_end.results, {})) {
      if (!sameState(state, run_.states[n++])) differs("back end", state.t_image);
      each(state, ms);
    }
  }
}

}  // namespace vir::tool
