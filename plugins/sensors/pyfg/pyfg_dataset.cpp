#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <iomanip>

#include "input_error.h"
#include "pyfg_dataset.h"
#include "vir/core/text_stream.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/roles/grabber_settings.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(PyfgDataset, vir)

namespace {

/// Events per doProcess(): enough to be fast, few enough to keep the queue small.
constexpr int kBatch = 64;

mrpt::obs::CObservation::Ptr rangeObservation(const char* label, TimeNs t, int id, double range_m,
                                              double sigma_m) {
  Range range;
  range.t = t;
  range.anchor = static_cast<std::uint32_t>(id);
  range.range_m = range_m;
  range.sigma_m = sigma_m;
  return rawlog::toObservation(range, label, rawlog::kUnknownRadio);
}

struct Converter {
  TimeNs t;
  std::map<std::string, long>* given;

  mrpt::obs::CObservation::Ptr operator()(const pyfg::TruePose& e) const {
    ++(*given)["ground_truth_poses"];
    return rawlog::toObservation(StampedPose{t, e.T_W_B}, rawlog::kGroundTruthLabel);
  }
  mrpt::obs::CObservation::Ptr operator()(const pyfg::OdometryPose& e) const {
    ++(*given)["odometry_poses"];
    const auto obs = rawlog::toObservation(StampedPose{t, e.T_O_B}, rawlog::kOdometryLabel);
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) obs->pose.cov(r, c) = e.step_covariance(r, c);
    }
    return obs;
  }
  mrpt::obs::CObservation::Ptr operator()(const pyfg::AnchorRange& e) const {
    ++(*given)["ranges"];
    return rangeObservation(rawlog::kRangeLabel, t, e.anchor, e.range_m, e.sigma_m);
  }
  mrpt::obs::CObservation::Ptr operator()(const pyfg::PeerRange& e) const {
    ++(*given)["peer_ranges"];
    return rangeObservation(rawlog::kPeerLabel, t, e.peer, e.range_m, e.sigma_m);
  }
};

}  // namespace

PyfgDataset::PyfgDataset() { m_sensorLabel = "PYFG"; }
PyfgDataset::~PyfgDataset() = default;

void PyfgDataset::describe(OptionVisitor& v) { pyfg::describe(v, options_); }

void PyfgDataset::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                            const std::string& section) {
  roles::readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
}

void PyfgDataset::initialize() {
  log_ = {};
  given_.clear();
  at_ = 0;
  m_state = ssInitializing;
  recording_ = pyfg::extractRobot(pyfg::readGraph(options_.source, &log_), options_, &log_);
  if (recording_.events.empty()) {
    throw InputError(options_.source + ": nothing to import for robot " + recording_.robot +
                     " with these settings");
  }
  for (const char peer : recording_.peers) {
    log_.note(std::string("robot ") + peer + " is beacon " + std::to_string(pyfg::robotId(peer)) +
              " under the label PEER");
  }
  initialized_ = true;
  m_state = ssWorking;
}

void PyfgDataset::doProcess() {
  if (!initialized_) throw InputError("PyfgDataset: doProcess() before initialize()");
  for (int i = 0; i < kBatch && !finished(); ++i) {
    const pyfg::Event& event = recording_.events[at_++];
    appendObservation(std::visit(Converter{event.t, &given_}, event.what));
  }
}

bool PyfgDataset::finished() const { return initialized_ && at_ == recording_.events.size(); }

double PyfgDataset::progress() const {
  if (!initialized_) return 0;
  return static_cast<double>(at_) / static_cast<double>(recording_.events.size());
}

std::vector<std::pair<std::string, long>> PyfgDataset::counters() const {
  std::vector<std::pair<std::string, long>> out(given_.begin(), given_.end());
  const auto problems = log_.counters();
  out.insert(out.end(), problems.begin(), problems.end());
  return out;
}

std::vector<std::string> PyfgDataset::warnings() const { return log_.messages(); }

std::vector<roles::TrueAnchor> PyfgDataset::trueAnchors() const {
  std::vector<roles::TrueAnchor> anchors;
  for (const pyfg::Landmark& l : recording_.landmarks) {
    anchors.push_back({static_cast<std::uint32_t>(l.name.number), l.p_W});
  }
  return anchors;
}

bool PyfgDataset::canRead(const std::string& source) const {
  TextStream file(source);
  std::string word;
  file >> std::setw(32) >> word;
  return word.rfind("VERTEX_", 0) == 0 || word.rfind("EDGE_", 0) == 0;
}

}  // namespace vir
