#include "vir/rawlog/ordered_reader.h"

namespace vir::rawlog {

mrpt::obs::CObservation::Ptr OrderedReader::next() {
  mrpt::obs::CObservation::Ptr out = orderer_.pop();
  while (!out && !ended_) {
    if (const auto read = reader_.next()) {
      orderer_.push(read);
    } else {
      ended_ = true;
      orderer_.flush();
    }
    out = orderer_.pop();
  }
  return out;
}

}  // namespace vir::rawlog
