/// An IMU whose gyro and accelerometer are files of their own.
#include <deque>
#include <memory>

#include "imu_pairing.h"
#include "readers.h"

namespace vir::euroc {
namespace {

class SplitImu : public RowStream<ImuSample> {
 public:
  SplitImu(std::unique_ptr<RowStream<VectorRow>> gyro, std::unique_ptr<RowStream<VectorRow>> acc,
           ProblemLog* log)
      : gyro_(std::move(gyro)), acc_(std::move(acc)), log_(log) {
    fill();
  }
  const ImuSample* peek() const override { return ready_.empty() ? nullptr : &ready_.front(); }
  void pop() override {
    ready_.pop_front();
    fill();
  }
  std::string where() const override { return gyro_->where(); }
  double progress() const override { return gyro_->progress(); }
  const std::string& path() const override { return gyro_->path(); }
  const std::string& name() const override { return gyro_->name(); }

 private:
  void fill() {
    while (ready_.empty() && (gyro_->peek() != nullptr || acc_->peek() != nullptr)) {
      const VectorRow* g = gyro_->peek();
      const VectorRow* a = acc_->peek();
      if (a != nullptr && (g == nullptr || a->t <= g->t)) {
        pairing_.addAccelerometer({a->t, a->v});
        acc_->pop();
      } else {
        pairing_.addGyro({g->t, g->v});
        gyro_->pop();
      }
      for (const ImuSample& s : pairing_.take()) ready_.push_back(s);
    }
    if (ready_.empty() && pairing_.dropped() > 0 && !said_) {
      said_ = true;
      log_->count("imu_not_paired", pairing_.dropped());
      log_->note(gyro_->path() + ": " + std::to_string(pairing_.dropped()) +
                 " readings have none of the accelerometer before and after them within 0.1 s");
    }
  }

  std::unique_ptr<RowStream<VectorRow>> gyro_, acc_;
  ProblemLog* log_;
  ImuPairing pairing_;
  std::deque<ImuSample> ready_;
  bool said_ = false;
};

}  // namespace

std::unique_ptr<RowStream<ImuSample>> openSplitImu(const std::string& gyro, const std::string& acc,
                                                   const Units& units, ProblemLog* log) {
  return std::make_unique<SplitImu>(openVectors(gyro, VectorKind::gyro, units, log),
                                    openVectors(acc, VectorKind::accelerometer, units, log), log);
}

}  // namespace vir::euroc
