/// What guards bytes of devices and text in pages.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "vir/core/crc.h"
#include "vir/core/markup.h"

namespace vir {
namespace {

const std::string kDigits = "123456789";  // what the catalogues of checksums use
const auto* const kBytes = reinterpret_cast<const std::uint8_t*>(kDigits.data());

TEST(Checksum, OfTheCatalogue) {
  EXPECT_EQ(crc16Ccitt(kBytes, kDigits.size()), 0x29B1);
  EXPECT_EQ(crc16Mavlink(kBytes, kDigits.size()), 0x6F91);
  EXPECT_EQ(crc16Ccitt(kBytes, 0), 0xFFFF);
}

TEST(Checksum, GoesOnFromAnEarlierOne) {
  for (std::size_t cut = 0; cut <= kDigits.size(); ++cut) {
    const std::uint16_t front = crc16Mavlink(kBytes, cut);
    EXPECT_EQ(crc16Mavlink(kBytes + cut, kDigits.size() - cut, front), 0x6F91) << cut;
  }
}

TEST(Markup, NothingOfATextBecomesAnElementOrEndsAnAttribute) {
  EXPECT_EQ(escapedMarkup("<b a=\"1\">&\n\x01Tür"), "&lt;b a=&quot;1&quot;&gt;&amp;  Tür");
}

}  // namespace
}  // namespace vir
