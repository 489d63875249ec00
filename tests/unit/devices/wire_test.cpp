#include "devices/wire.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/emulated_line.hpp"
#include "unit/devices/scanner_checks.hpp"

namespace loopstone {
namespace {

using test::EmulatedLine;
using test::error_of;
using testing::HasSubstr;

TEST(Wire, AConnectionThatIsResetIsClosed) {
  EmulatedLine line(EmulatedLine::Kind::kTcp);
  Wire wire(parse_device_address("scip://" + line.place()), {}, 60.0);
  EXPECT_EQ(line.read(60'000), "");
  // What was said and never read makes it a reset.
  wire.write("QT\n");
  line.disconnect();
  EXPECT_THAT(error_of([&] { (void)wire.read(60.0); }), HasSubstr("has closed the connection"));
}

}  // namespace
}  // namespace loopstone
