#include "turn_axes.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

/// What changes less than this share of the rate is turning that goes on and on.
constexpr double kChanging = 0.3;
constexpr double kMostBias = 0.5;  // [rad/s] no gyro has more

Vec3 medianOf(const std::vector<Vec3>& all) {
  Vec3 out;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vec3& v : all) values.push_back(v[axis]);
    out[axis] = medianInPlace(&values);
  }
  return out;
}

double medianNorm(const std::vector<Vec3>& all, const Vec3& from) {
  std::vector<double> sizes;
  for (const Vec3& v : all) sizes.push_back((v - from).norm());
  return medianInPlace(&sizes);
}

struct Rates {
  std::vector<Vec3> image, gyro;
};

Rates ratesOf(const std::vector<TurnPair>& pairs) {
  Rates out;
  for (const TurnPair& p : pairs) {
    out.image.push_back(p.image_C);
    out.gyro.push_back(p.gyro_B);
  }
  return out;
}

}  // namespace

Vec3 biasWith(const std::vector<TurnPair>& pairs, const Mat3& R_C_B) {
  const Rates rates = ratesOf(pairs);
  const Vec3 middle = medianOf(rates.image);
  if (medianNorm(rates.image, middle) < kChanging * medianNorm(rates.image, Vec3::Zero())) {
    return Vec3::Zero();
  }
  std::vector<Vec3> beside;
  for (const TurnPair& p : pairs) beside.push_back(p.gyro_B - R_C_B.transpose() * p.image_C);
  const Vec3 bias = medianOf(beside);
  return bias.norm() < kMostBias ? bias : Vec3::Zero();
}

double restOf(const std::vector<TurnPair>& pairs, const Mat3& R_C_B) {
  const Vec3 bias = biasWith(pairs, R_C_B);
  std::vector<double> rest;
  for (const TurnPair& p : pairs) {
    const Vec3 gyro = p.gyro_B - bias;
    const double size = std::max(p.image_C.norm(), gyro.norm());
    rest.push_back((p.image_C - R_C_B * gyro).norm() / size);
  }
  return medianInPlace(&rest);
}

AxesFit fitAxes(const std::vector<TurnPair>& pairs) {
  AxesFit fit;
  Vec3 bias_rotation = Vec3::Zero(), bias_mirror = Vec3::Zero();
  // A constant turns the axes that fit best, and they the constant.
  for (int round = 0; round < 5; ++round) {
    for (const bool mirror : {false, true}) {
      const Vec3& bias = mirror ? bias_mirror : bias_rotation;
      Mat3 sum = Mat3::Zero();
      for (const TurnPair& p : pairs) {
        const Vec3 gyro = p.gyro_B - bias;
        // Directions weighted by the rate, so that outliers of one image do not decide.
        const double weight = 1 / std::max(p.image_C.norm(), gyro.norm());
        sum += weight * p.image_C * gyro.transpose();
      }
      const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Mat3 free = svd.matrixU() * svd.matrixV().transpose();
      const double sign = (free.determinant() < 0) != mirror ? -1 : 1;
      const Mat3 best = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
      (mirror ? fit.mirror : fit.rotation) = best;
      (mirror ? bias_mirror : bias_rotation) = biasWith(pairs, best);
      const Vec3 s = svd.singularValues();
      if (!mirror) fit.second_axis = s(0) > 0 ? s(1) / s(0) : 0;
    }
  }
  fit.rotation_rest = restOf(pairs, fit.rotation);
  fit.mirror_rest = restOf(pairs, fit.mirror);
  return fit;
}

double ratioOf(const std::vector<TurnPair>& pairs) {
  const Rates rates = ratesOf(pairs);
  const Vec3 image = medianOf(rates.image), gyro = medianOf(rates.gyro);
  const double changing = medianNorm(rates.image, image);
  const double all = medianNorm(rates.image, Vec3::Zero());
  if (changing > kChanging * all) return medianNorm(rates.gyro, gyro) / changing;
  return medianNorm(rates.gyro, Vec3::Zero()) / all;
}

}  // namespace vir::check
