/// Export to EuRoC's folder layout.
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <Eigen/Core>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "recordings/exporter.h"
#include "vir/core/settings.h"
#include "vir/core/text.h"
#include "vir/formats/lens_names.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using namespace mrpt::obs;

std::string listed(const std::vector<double>& numbers) {
  std::string text;
  for (const double v : numbers) text += (text.empty() ? "" : ", ") + exact(v);
  return "[" + text + "]";
}

std::string extrinsics(const Pose& T_B_S) {
  const Mat3 R = T_B_S.R();
  std::vector<double> m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m.push_back(R(r, c));
    m.push_back(T_B_S.p[r]);
  }
  m.insert(m.end(), {0, 0, 0, 1});
  return "T_BS:\n  cols: 4\n  rows: 4\n  data: " + listed(m) + "\n";
}

/// Model, intrinsics and distortion as the datasets' own files name them.
std::string lensYaml(const CameraCalibration& c) {
  formats::ListedLens lens = formats::listedLens(c);
  std::vector<double>& k = lens.before_focal;
  k.insert(k.end(), {c.fx, c.fy, c.cx, c.cy});
  if (c.distortion == Distortion::none) {
    lens.distortion_model = "radtan";
    lens.coefficients.assign(4, 0);
  }
  if (lens.distortion_model == "radtan") lens.distortion_model = "radial-tangential";
  return "camera_model: " + lens.camera_model + "\nintrinsics: " + listed(k) +
         "\ndistortion_model: " + lens.distortion_model +
         "\ndistortion_coefficients: " + listed(lens.coefficients) + "\n";
}

std::string cameraYaml(const CObservationImage& o) {
  const CameraCalibration c = rawlog::fromMrptCamera(o.cameraParams);
  return "sensor_type: camera\n" + extrinsics(rawlog::fromMrptPose(o.cameraPose)) +
         "resolution: [" + std::to_string(c.width) + ", " + std::to_string(c.height) + "]\n" +
         lensYaml(c);
}

/// The noise densities that import found, so that they are not lost on the way back.
std::string imuNoise(const std::string& companion) {
  if (companion.empty()) return {};
  const Settings settings = Settings::fromFile(companion);
  std::string text;
  for (const auto& [key, name] : {std::pair{"gyro_noise_density", "gyroscope_noise_density"},
                                  std::pair{"gyro_random_walk", "gyroscope_random_walk"},
                                  std::pair{"acc_noise_density", "accelerometer_noise_density"},
                                  std::pair{"acc_random_walk", "accelerometer_random_walk"}}) {
    const Setting* s = settings.find("Imu", key);
    if (s != nullptr) text += std::string(name) + ": " + s->value + "\n";
  }
  return text;
}

class EurocExporter : public Exporter {
 public:
  EurocExporter(const std::string& folder, std::string companion, AnchorTexts anchors)
      : target_((fs::path(folder) / "mav0").string()),
        mav0_(target_ + ".part"),
        companion_(std::move(companion)),
        files_(mav0_),
        anchors_(std::move(anchors)) {
    if (fs::exists(target_)) {
      throw std::runtime_error(target_ + " exists already; remove it or name another folder");
    }
    std::error_code ignored;
    fs::remove_all(mav0_, ignored);  // of an export that was killed
  }
  ~EurocExporter() override {
    std::error_code ignored;
    fs::remove_all(mav0_, ignored);
  }

  Added add(CObservation& o) override {
    const TimeNs t = rawlog::fromMrptTime(o.timestamp);
    if (auto* image = dynamic_cast<CObservationImage*>(&o)) {
      return addImage(*image, t) ? Added::written : Added::unusable;
    } else if (const auto* imu = dynamic_cast<const CObservationIMU*>(&o)) {
      return addImu(*imu, t) ? Added::written : Added::no_place;
    } else if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(&o)) {
      if (o.sensorLabel != rawlog::kGroundTruthLabel) return Added::no_place;
      addTruth(rawlog::fromMrptPose(pose->pose.mean), t);
    } else if (const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&o)) {
      if (o.sensorLabel == rawlog::kPeerLabel) return Added::no_place;
      if (rawlog::differenceReferenceOf(o.sensorLabel)) return Added::no_place;
      addRanges(*ranges, t);
    } else {
      return Added::no_place;
    }
    return Added::written;
  }

  void finish() override {
    files_.close();
    if (fs::exists(mav0_)) fs::rename(mav0_, target_);
  }

 private:
  std::string sensor(const CObservation& o) const { return lowerCase(fileName(o.sensorLabel)); }

  /// Once per sensor.
  void calibration(const std::string& sensor, const std::string& yaml) {
    if (!calibrated_.insert(sensor).second) return;
    files_.at(sensor + "/sensor.yaml", "").stream() << yaml;
  }

  /// False for an image whose file is missing or cannot be decoded.
  bool addImage(CObservationImage& o, TimeNs t) {
    const std::string name = std::to_string(t) + ".png";
    const fs::path folder = fs::path(mav0_) / sensor(o) / "data";
    std::error_code error;
    fs::create_directories(folder, error);
    const bool external = o.image.isExternallyStored();
    const fs::path from = external ? o.image.getExternalStorageFileAbsolutePath() : "";
    if (external && !fs::exists(from)) return false;
    if (external && isPngFile(from)) {
      fs::copy_file(from, folder / name, error);
      if (error) {
        throw std::runtime_error("cannot copy " + from.string() + " to " +
                                 (folder / name).string() + ": " + error.message());
      }
    } else {
      if (!decoded(o)) return false;
      if (!o.image.saveToFile((folder / name).string())) {
        throw std::runtime_error("cannot write " + (folder / name).string());
      }
      if (external) o.image.unload();
    }
    calibration(sensor(o), cameraYaml(o));
    files_.at(sensor(o) + "/data.csv", "#timestamp [ns],filename")
        .line(std::to_string(t) + "," + name);
    return true;
  }

  static bool isPngFile(const fs::path& file) {
    if (file.extension() != ".png") return false;
    std::ifstream in(file, std::ios::binary);
    char begin[8] = {};
    return in.read(begin, sizeof begin) && isPng({begin, sizeof begin});
  }

  static bool decoded(CObservationImage& o) {
    try {
      o.load();
      return !o.image.isEmpty();
    } catch (const std::exception&) {
      return false;  // counted by the caller
    }
  }

  bool addImu(const CObservationIMU& o, TimeNs t) {
    std::string line = std::to_string(t);
    for (const auto index : {IMU_WX, IMU_WY, IMU_WZ, IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC}) {
      if (!o.has(index)) return false;
      line += "," + exact(o.get(index));
    }
    calibration(sensor(o), "sensor_type: imu\n" + extrinsics(rawlog::fromMrptPose(o.sensorPose)) +
                               imuNoise(companion_));
    files_
        .at(sensor(o) + "/data.csv",
            "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x "
            "[m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]")
        .line(line);
    return true;
  }

  void addTruth(const Pose& T, TimeNs t) {
    std::string line = std::to_string(t);
    for (const double v : {T.p.x(), T.p.y(), T.p.z(), T.q.w(), T.q.x(), T.q.y(), T.q.z()}) {
      line += "," + exact(v);
    }
    files_
        .at("state_groundtruth_estimate0/data.csv",
            "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
            "q_RS_z []")
        .line(line);
  }

  void addRanges(const CObservationBeaconRanges& o, TimeNs t) {
    for (const auto& m : o.sensedData) {
      const auto& antenna = m.sensorLocationOnRobot;
      const Pose T_B_S(Quat::Identity(), Vec3(antenna.x(), antenna.y(), antenna.z()));
      calibration(sensor(o), "sensor_type: uwb\n" + extrinsics(T_B_S) +
                                 "range_noise_sigma: " + exact(o.stdError) + "\n");
      files_.at(sensor(o) + "/data.csv", "#timestamp [ns],anchor_id,range [m]")
          .line(std::to_string(t) + "," +
                anchorText(anchors_, static_cast<std::uint32_t>(m.beaconID)) + "," +
                exact(m.sensedDistance));
    }
  }

  std::string target_, mav0_, companion_;
  FileSet files_;
  std::set<std::string> calibrated_;
  AnchorTexts anchors_;
};

}  // namespace

std::unique_ptr<Exporter> makeEurocExporter(const std::string& folder, const std::string& companion,
                                            AnchorTexts anchors) {
  return std::make_unique<EurocExporter>(folder, companion, std::move(anchors));
}

}  // namespace vir::app
