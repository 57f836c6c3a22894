#pragma once
/// What DDS hands out is given back.
#include <dds/dds.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace vir::dds {

/// An entity of DDS, deleted with all that was made from it. Throws std::runtime_error naming
/// `what` if it is none but an error.
class Entity {
 public:
  Entity() = default;
  Entity(dds_entity_t handle, const std::string& what) : handle_(handle) {
    if (handle_ < 0) throw std::runtime_error("DDS: no " + what + ": " + dds_strretcode(-handle_));
  }
  ~Entity() { reset(); }
  Entity(Entity&& other) noexcept : handle_(other.handle_) { other.handle_ = 0; }
  Entity& operator=(Entity&& other) noexcept {
    if (this != &other) {
      reset();
      handle_ = other.handle_;
      other.handle_ = 0;
    }
    return *this;
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  dds_entity_t get() const { return handle_; }

 private:
  void reset() {
    if (handle_ > 0) dds_delete(handle_);
    handle_ = 0;
  }
  dds_entity_t handle_ = 0;
};

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;
inline Qos newQos() { return Qos(dds_create_qos()); }

}  // namespace vir::dds
