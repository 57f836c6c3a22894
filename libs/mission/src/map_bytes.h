#pragma once
/// Internal: numbers of a map file, least significant byte first.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "vir/core/little_endian.h"
#include "vir/geometry/pose.h"

namespace vir::mission {

class MapWriter {
 public:
  void whole(std::uint64_t v, int bytes) { put(&out_, v, bytes); }
  void real(double v) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    put(&out_, bits, 8);
  }
  void small(float v) { putFloat(&out_, v); }
  template <typename Vector>
  void reals(const Vector& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) real(v.data()[i]);
  }
  void pose(const Pose& T) {
    reals(T.p);
    reals(T.q.coeffs());
  }
  void bytes(const void* data, std::size_t size) {
    out_.append(static_cast<const char*>(data), size);
  }
  std::string& out() { return out_; }

 private:
  std::string out_;
};

/// Throws std::runtime_error where the bytes end early or a value cannot be.
class MapReader {
 public:
  MapReader(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  template <int Bytes>
  std::uint64_t whole() {
    return unsignedAt<Bytes>(take(Bytes));
  }
  double real() {
    const std::uint64_t bits = whole<8>();
    double v = 0;
    std::memcpy(&v, &bits, sizeof v);
    return finite(v);
  }
  float small() { return static_cast<float>(finite(floatAt(take(4)))); }
  template <typename Vector>
  void reals(Vector* v) {
    for (Eigen::Index i = 0; i < v->size(); ++i) v->data()[i] = real();
  }
  Pose pose() {
    Pose T;
    reals(&T.p);
    reals(&T.q.coeffs());
    require(std::abs(T.q.norm() - 1) < 1e-6, "a rotation that is none");
    T.q.normalize();
    return T;
  }
  /// Of things that take at least `size` bytes each.
  std::size_t count(std::size_t size) {
    const std::uint64_t n = whole<4>();
    require(n <= left_ / size, "more entries than it has bytes");
    return static_cast<std::size_t>(n);
  }
  /// The next bytes for themselves, with their length in front.
  MapReader part() {
    const std::uint64_t size = whole<8>();
    require(size <= left_, "it ends early");
    return {take(static_cast<std::size_t>(size)), static_cast<std::size_t>(size)};
  }
  void bytes(void* to, std::size_t size) { std::memcpy(to, take(size), size); }
  std::size_t left() const { return left_; }

  static void require(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(std::string("it is damaged: ") + what);
  }

 private:
  const std::uint8_t* take(std::size_t size) {
    require(size <= left_, "it ends early");
    const std::uint8_t* at = data_;
    data_ += size;
    left_ -= size;
    return at;
  }
  static double finite(double v) {
    require(std::isfinite(v) && std::abs(v) < 1e12, "a value that cannot be");
    return v;
  }

  const std::uint8_t* data_;
  std::size_t left_;
};

}  // namespace vir::mission
