#include "vir/rawlog/mrpt_error.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace vir::rawlog {
namespace {

const char* const kWrapped =
    "==== MRPT exception ====\ncannot write a.rawlog: File too large\nCall stack backtrace:\n"
    "[0 ]     0x7f1bab721cdb \n[9 ] (unknown file) __libc_start_main\n";
const char* const kThrown =
    "==== MRPT exception ====\n/src/CImage.cpp:12: [void f()] Message: no such image\n"
    "Call stack backtrace:\n[0 ] 0x1\n";

/// The first said "==== MRPT exception ====" and nothing else.
TEST(MrptError, IsOneLineOfWhatWasWrong) {
  EXPECT_EQ(shortReason(std::runtime_error(kWrapped)), "cannot write a.rawlog: File too large");
  EXPECT_EQ(shortReason(std::runtime_error(kThrown)), "no such image");
  EXPECT_EQ(shortReason(std::runtime_error("plain\nsecond line")), "plain");
  EXPECT_EQ(shortReason(std::runtime_error("")), "unknown reason");
}

TEST(MrptError, OtherTextsStayAsTheyAre) {
  EXPECT_EQ(withoutStackTrace(std::runtime_error(kWrapped)),
            "cannot write a.rawlog: File too large");
  EXPECT_EQ(withoutStackTrace(std::runtime_error("plain\nsecond line")), "plain\nsecond line");
}

}  // namespace
}  // namespace vir::rawlog
