#include "recordings/ros_messages.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "vir/types/fixed_axes.h"

namespace vir::app {
namespace {

using bags::CdrWriter;

/// Types that are no part of what our reader knows by heart.
const std::map<std::string, std::string>& ownTypes() {
  static const std::map<std::string, std::string> types{
      {"vir_slam/Range",
       "std_msgs/Header header\nint64 anchor\nfloat64 range_m\nfloat64 sigma_m\n"
       "geometry_msgs/Point antenna\nstring anchor_name\n"},
      {"nav_msgs/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"},
      {"std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"},
      {"sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
      {"sensor_msgs/PointCloud2",
       "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\n"
       "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
      {"visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"},
      {"visualization_msgs/MeshFile", "string filename\nuint8[] data\n"},
      {"visualization_msgs/Marker",
       "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
       "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
       "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
       "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
       "sensor_msgs/CompressedImage texture\nUVCoordinate[] uv_coordinates\nstring text\n"
       "string mesh_resource\nMeshFile mesh_file\nbool mesh_use_embedded_materials\n"},
      {"visualization_msgs/MarkerArray", "Marker[] markers\n"}};
  return types;
}

CdrWriter header(TimeNs t, const std::string& frame) {
  CdrWriter w;
  w.time(t).text(frame);
  return w;
}

void add(CdrWriter* w, const Vec3& v) { w->f64(v.x()).f64(v.y()).f64(v.z()); }
void add(CdrWriter* w, const Quat& q) { w->f64(q.x()).f64(q.y()).f64(q.z()).f64(q.w()); }
void add(CdrWriter* w, const Pose& T) {
  add(w, T.p);
  add(w, T.q);
}
void zeros(CdrWriter* w, int n) {
  for (int i = 0; i < n; ++i) w->f64(0);
}

}  // namespace

void RosMessages::write(const std::string& topic, const std::string& type, TimeNs t,
                        const CdrWriter& message) {
  sink_.write(channel(topic, type), t, message.bytes());
}

std::uint16_t RosMessages::channel(const std::string& topic, const std::string& type) {
  const auto known = channels_.find(topic);
  if (known != channels_.end()) return known->second;
  return channels_[topic] =
             sink_.channel(topic, type, bags::fullDefinition(type, ownTypes()), metadata_[topic]);
}

std::uint16_t RosMessages::advertiseCompressedImage(const std::string& topic) {
  return channel(topic, "sensor_msgs/CompressedImage");
}

void RosMessages::imu(const std::string& topic, const std::string& frame, const ImuSample& s) {
  CdrWriter w = header(s.t, frame);
  add(&w, Quat::Identity());
  w.f64(-1);  // there is no attitude
  zeros(&w, 8);
  add(&w, s.gyro);
  zeros(&w, 9);
  add(&w, s.acc);
  zeros(&w, 9);
  write(topic, "sensor_msgs/Imu", s.t, w);
}

void RosMessages::image(const std::string& topic, const std::string& frame, TimeNs t, int width,
                        int height, const std::string& encoding, const std::uint8_t* pixels) {
  const std::size_t step = static_cast<std::size_t>(width) * (encoding == "mono8" ? 1 : 3);
  const std::size_t size = step * static_cast<std::size_t>(height);
  CdrWriter w = header(t, frame);
  w.u32(static_cast<std::uint32_t>(height)).u32(static_cast<std::uint32_t>(width)).text(encoding);
  w.u8(0).u32(static_cast<std::uint32_t>(step)).u32(static_cast<std::uint32_t>(size));
  w.raw(pixels, size);
  write(topic, "sensor_msgs/Image", t, w);
}

void RosMessages::compressedImage(const std::string& topic, const std::string& frame, TimeNs t,
                                  const std::string& format, const std::string& bytes) {
  CdrWriter w = header(t, frame);
  w.text(format).u32(static_cast<std::uint32_t>(bytes.size())).raw(bytes.data(), bytes.size());
  write(topic, "sensor_msgs/CompressedImage", t, w);
}

bool RosMessages::cameraInfo(const std::string& topic, const std::string& frame, TimeNs t,
                             const CameraCalibration& c) {
  std::string model = "plumb_bob";
  std::size_t count = 5;
  if (c.distortion == Distortion::equidistant) {
    model = "equidistant", count = 4;
  } else if (c.distortion == Distortion::rational) {
    model = "rational_polynomial", count = 8;
  } else if (c.distortion == Distortion::omni || c.distortion == Distortion::double_sphere) {
    return false;
  }
  CdrWriter w = header(t, frame);
  w.u32(static_cast<std::uint32_t>(c.height)).u32(static_cast<std::uint32_t>(c.width)).text(model);
  w.u32(static_cast<std::uint32_t>(count));
  for (std::size_t i = 0; i < count; ++i) w.f64(c.distortion == Distortion::none ? 0 : c.dist[i]);
  for (const double v : {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0}) w.f64(v);
  for (const double v : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) w.f64(v);
  for (const double v : {c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0}) w.f64(v);
  w.u32(0).u32(0);                               // no binning
  w.u32(0).u32(0).u32(0).u32(0).boolean(false);  // the whole image
  write(topic, "sensor_msgs/CameraInfo", t, w);
  return true;
}

void RosMessages::pose(const std::string& topic, const std::string& frame,
                       const StampedPose& pose) {
  CdrWriter w = header(pose.t, frame);
  add(&w, pose.T_W_B);
  write(topic, "geometry_msgs/PoseStamped", pose.t, w);
}

void RosMessages::pose(const std::string& topic, const std::string& frame, const StampedPose& pose,
                       const Mat3& covariance) {
  CdrWriter w = header(pose.t, frame);
  add(&w, pose.T_W_B);
  for (int i = 0; i < 36; ++i) {
    w.f64(i / 6 < 3 && i % 6 < 3 ? covariance(i / 6, i % 6) : 0);
  }
  write(topic, "geometry_msgs/PoseWithCovarianceStamped", pose.t, w);
}

void RosMessages::odometry(const std::string& topic, const std::string& frame,
                           const std::string& child, const StampedPose& pose) {
  CdrWriter w = header(pose.t, frame);
  w.text(child);
  add(&w, pose.T_W_B);
  zeros(&w, 36 + 6 + 36);
  write(topic, "nav_msgs/Odometry", pose.t, w);
}

void RosMessages::odometry(const std::string& topic, const std::string& frame,
                           const std::string& child, const StateEstimate& estimate) {
  const State& s = estimate.state;
  CdrWriter w = header(s.t, frame);
  w.text(child);
  add(&w, s.T_W_B);
  const Mat3 R_W_B = s.T_W_B.q.toRotationMatrix();
  const Eigen::Matrix<double, 6, 6> covariance = fixedAxesCovariance(s.T_W_B, estimate.covariance);
  for (int i = 0; i < 36; ++i) w.f64(covariance(i / 6, i % 6));
  add(&w, Vec3(R_W_B.transpose() * s.v));
  zeros(&w, 3 + 36);
  write(topic, "nav_msgs/Odometry", s.t, w);
}

void RosMessages::path(const std::string& topic, const std::string& frame, TimeNs t,
                       const std::vector<StampedPose>& poses) {
  CdrWriter w = header(t, frame);
  w.u32(static_cast<std::uint32_t>(poses.size()));
  for (const StampedPose& p : poses) {
    w.time(p.t).text(frame);
    add(&w, p.T_W_B);
  }
  write(topic, "nav_msgs/Path", t, w);
}

void RosMessages::transform(const std::string& topic, const std::string& frame,
                            const std::string& child, const StampedPose& pose) {
  CdrWriter w;
  w.u32(1).time(pose.t).text(frame).text(child);
  add(&w, pose.T_W_B);
  write(topic, "tf2_msgs/TFMessage", pose.t, w);
}

void RosMessages::range(const std::string& topic, const std::string& frame, const Range& r,
                        const std::string& name) {
  CdrWriter w = header(r.t, frame);
  w.i64(static_cast<std::int64_t>(r.anchor)).f64(r.range_m).f64(r.sigma_m);
  add(&w, r.p_B_U);
  w.text(name);
  write(topic, "vir_slam/Range", r.t, w);
}

void RosMessages::points(const std::string& topic, const std::string& frame, TimeNs t,
                         const std::vector<Eigen::Vector3f>& points) {
  constexpr std::uint8_t kFloat32 = 7;
  const auto n = static_cast<std::uint32_t>(points.size());
  CdrWriter w = header(t, frame);
  w.u32(1).u32(n).u32(3);
  std::uint32_t offset = 0;
  for (const char* axis : {"x", "y", "z"}) {
    w.text(axis).u32(offset).u8(kFloat32).u32(1);
    offset += 4;
  }
  w.boolean(false).u32(12).u32(12 * n).u32(12 * n);
  for (const Eigen::Vector3f& p : points) w.raw(p.data(), 12);
  w.boolean(true);
  write(topic, "sensor_msgs/PointCloud2", t, w);
}

void RosMessages::ellipsoids(const std::string& topic, const std::string& frame, TimeNs t,
                             const std::vector<Ellipsoid>& all) {
  constexpr std::int32_t kSphere = 2, kText = 9;
  CdrWriter w;
  w.u32(static_cast<std::uint32_t>(2 * all.size()));
  std::int32_t id = 0;
  for (const Ellipsoid& e : all) {
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(e.covariance);
    Mat3 R = axes.eigenvectors();
    if (R.determinant() < 0) R.col(0) = -R.col(0);
    const Vec3 sizes = 6 * axes.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseMax(0.02);
    for (const std::int32_t type : {kSphere, kText}) {
      const bool text = type == kText;
      w.time(t).text(frame).text("anchors").i32(id++).i32(type).i32(0);
      add(&w, text ? Pose(Quat::Identity(), e.p + Vec3(0, 0, 0.3)) : Pose(Quat(R), e.p));
      add(&w, text ? Vec3(0.2, 0.2, 0.2) : sizes);
      w.f32(text ? 1 : 0.2F).f32(text ? 1 : 0.6F).f32(1).f32(text ? 1 : 0.5F);
      w.i32(0).u32(0).boolean(false).u32(0).u32(0).text("");
      w.time(0).text("").text("").u32(0);  // no texture
      w.u32(0).text(text ? e.name : "").text("").text("").u32(0).boolean(false);
    }
  }
  write(topic, "visualization_msgs/MarkerArray", t, w);
}

}  // namespace vir::app
