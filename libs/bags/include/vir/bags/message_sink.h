#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "vir/bags/bytes.h"
#include "vir/core/time.h"

namespace vir::bags {

/// What a file says of a topic beside its type: texts by name.
using Metadata = std::map<std::string, std::string>;

/// Where messages of ROS 2 go: a file, or whoever listens.
class MessageSink {
 public:
  virtual ~MessageSink() = default;
  /// `type` is package/Type; one topic has one type. The same number for the same topic.
  virtual std::uint16_t channel(const std::string& topic, const std::string& type,
                                const std::string& definition, const Metadata& metadata) = 0;
  virtual void write(std::uint16_t channel, TimeNs t, const Bytes& cdr) = 0;
};

}  // namespace vir::bags
