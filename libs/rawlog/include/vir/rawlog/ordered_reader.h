#pragma once
#include <string>

#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/time_orderer.h"

namespace vir::rawlog {

/// The observations of a rawlog in the order of their stamps.
class OrderedReader {
 public:
  /// Throws as RawlogReader does.
  explicit OrderedReader(const std::string& path, const TimeOrdererOptions& options = {})
      : reader_(path), orderer_(options) {}

  /// The next observation, or nullptr at the end.
  mrpt::obs::CObservation::Ptr next();

  /// How far it is, and what is wrong with the file.
  const RawlogReader& reader() const { return reader_; }
  /// What was left out on account of its stamp.
  const TimeOrderer& orderer() const { return orderer_; }

 private:
  RawlogReader reader_;
  TimeOrderer orderer_;
  bool ended_ = false;
};

}  // namespace vir::rawlog
