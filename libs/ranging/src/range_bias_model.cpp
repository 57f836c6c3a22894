#include "vir/ranging/range_bias_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "vir/core/parse_number.h"
#include "vir/core/text_file.h"

namespace vir::ranging {
namespace {

constexpr double kGrowth = 0.02;  ///< of sigma beyond the table [m/m]
const char* const kFirstLine = "# vir-slam range bias model 1";
const char* const kNoise = "# noise_sigma_m = ";
const char* const kHeader = "distance_m,bias_m,sigma_m";

[[noreturn]] void fail(const std::string& name, int line, const std::string& problem) {
  throw RangeBiasModelError(name + ":" + std::to_string(line) + ": " + problem);
}

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", v);
  return text;
}

RangeBiasModel::Node parseNode(const std::string& line, const std::string& name, int at) {
  std::vector<double> values;
  std::istringstream fields(line);
  for (std::string field; std::getline(fields, field, ',');) {
    double value = 0;
    field.erase(0, std::min(field.find_first_not_of(" \t"), field.size()));
    if (!parseFinite(field, &value)) fail(name, at, "'" + field + "' is no finite number");
    values.push_back(value);
  }
  if (values.size() != 3) {
    fail(name, at,
         "expected 3 numbers (" + std::string(kHeader) + "), found " +
             std::to_string(values.size()));
  }
  return {values[0], values[1], values[2]};
}

/// Empty, or what is wrong with a node after the ones before it.
std::string problemOf(const std::vector<RangeBiasModel::Node>& nodes, std::size_t i) {
  const RangeBiasModel::Node& n = nodes[i];
  if (!std::isfinite(n.distance_m) || !std::isfinite(n.bias_m) || !std::isfinite(n.sigma_m)) {
    return "a value is not finite";
  }
  if (n.distance_m < 0) return "a distance must not be negative";
  if (n.sigma_m < 0) return "a sigma must not be negative";
  if (i > 0 && n.distance_m <= nodes[i - 1].distance_m) {
    return "distances must ascend, " + number(n.distance_m) + " follows " +
           number(nodes[i - 1].distance_m);
  }
  return {};
}

}  // namespace

RangeBiasModel::RangeBiasModel(std::vector<Node> nodes, double noise_sigma_m)
    : nodes_(std::move(nodes)), noise_sigma_m_(noise_sigma_m) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const std::string problem = problemOf(nodes_, i);
    if (problem.empty()) continue;
    throw RangeBiasModelError("range bias model, node " + std::to_string(i + 1) + ": " + problem);
  }
  if (!std::isfinite(noise_sigma_m) || noise_sigma_m < 0) {
    throw RangeBiasModelError("range bias model: the noise must be a number of at least 0");
  }
}

/// 0 at both ends, so that the constant beyond joins smoothly.
double RangeBiasModel::slopeAtNode(std::size_t i) const {
  if (i == 0 || i + 1 == nodes_.size()) return 0;
  return (nodes_[i + 1].bias_m - nodes_[i - 1].bias_m) /
         (nodes_[i + 1].distance_m - nodes_[i - 1].distance_m);
}

RangeBiasModel::Bias RangeBiasModel::at(double distance_m) const {
  if (nodes_.empty() || std::isnan(distance_m)) return {};
  const auto beyond = [](const Node& end, double excess) {
    return Bias{end.bias_m, std::hypot(end.sigma_m, kGrowth * excess), 0};
  };
  if (distance_m <= nodes_.front().distance_m) {
    return beyond(nodes_.front(), nodes_.front().distance_m - distance_m);
  }
  if (distance_m >= nodes_.back().distance_m) {
    return beyond(nodes_.back(), distance_m - nodes_.back().distance_m);
  }
  const auto next = std::upper_bound(nodes_.begin(), nodes_.end(), distance_m,
                                     [](double d, const Node& n) { return d < n.distance_m; });
  const std::size_t j = static_cast<std::size_t>(next - nodes_.begin()), i = j - 1;
  const Node &a = nodes_[i], &b = nodes_[j];
  const double width = b.distance_m - a.distance_m;
  const double s = (distance_m - a.distance_m) / width;
  const double ta = slopeAtNode(i) * width, tb = slopeAtNode(j) * width;
  // Hermite basis.
  const double s2 = s * s, s3 = s2 * s;
  Bias out;
  out.mean_m = (2 * s3 - 3 * s2 + 1) * a.bias_m + (s3 - 2 * s2 + s) * ta +
               (3 * s2 - 2 * s3) * b.bias_m + (s3 - s2) * tb;
  out.slope = ((6 * s2 - 6 * s) * (a.bias_m - b.bias_m) + (3 * s2 - 4 * s + 1) * ta +
               (3 * s2 - 2 * s) * tb) /
              width;
  out.sigma_m = (1 - s) * a.sigma_m + s * b.sigma_m;
  return out;
}

double RangeBiasModel::corrected(double measured_m) const {
  // Converges since the slope of a bias is far below 1; a few steps reach rounding.
  double d = measured_m;
  for (int k = 0; k < 8; ++k) d = measured_m - at(d).mean_m;
  return d;
}

std::string RangeBiasModel::text() const {
  std::string out = std::string(kFirstLine) + "\n";
  out += kNoise + number(noise_sigma_m_) + "\n" + kHeader + "\n";
  for (const Node& n : nodes_) {
    out += number(n.distance_m) + "," + number(n.bias_m) + "," + number(n.sigma_m) + "\n";
  }
  return out;
}

RangeBiasModel RangeBiasModel::fromText(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  std::vector<Node> nodes;
  double noise = 0;
  bool header = false;
  int at = 0;
  for (std::string line; readLine(in, &line);) {
    ++at;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (at == 1 && line != kFirstLine) {
      fail(name, at, "not a bias model: the first line must be '" + std::string(kFirstLine) + "'");
    }
    if (line.rfind(kNoise, 0) == 0 &&
        !parseFinite(line.substr(std::string(kNoise).size()), &noise)) {
      fail(name, at, "the noise is no finite number");
    }
    if (line.empty() || line[0] == '#') continue;
    if (!header) {
      if (line != kHeader) fail(name, at, "expected the header '" + std::string(kHeader) + "'");
      header = true;
      continue;
    }
    nodes.push_back(parseNode(line, name, at));
    const std::string problem = problemOf(nodes, nodes.size() - 1);
    if (!problem.empty()) fail(name, at, problem);
  }
  if (!header)
    fail(name, at, "empty or cut off: the header '" + std::string(kHeader) + "' is missing");
  if (noise < 0) fail(name, 2, "the noise must not be negative");
  return RangeBiasModel(std::move(nodes), noise);
}

}  // namespace vir::ranging
