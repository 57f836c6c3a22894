#pragma once
#include <stdexcept>

namespace vir {

/// The recording cannot be imported at all: what() says which file, what is wrong and what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace vir
