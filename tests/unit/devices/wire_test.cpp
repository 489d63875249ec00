#include "devices/wire.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>

#include "support/emulated_line.hpp"
#include "unit/devices/scanner_checks.hpp"

namespace loopstone {
namespace {

using test::EmulatedLine;
using test::error_of;
using testing::HasSubstr;

TEST(Wire, APortIsItsAloneWhileItIsOpen) {
  const EmulatedLine line(EmulatedLine::Kind::kTerminal);
  const Descriptor other(::open(line.place().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  const auto is_exclusive = [&] {
    int exclusive = -1;
    EXPECT_EQ(::ioctl(other.number(), TIOCGEXCL, &exclusive), 0);
    return exclusive == 1;
  };
  {
    const Wire wire(parse_device_address("rplidar://" + line.place()), {}, 60.0);
    EXPECT_TRUE(is_exclusive());
  }
  EXPECT_FALSE(is_exclusive());
}

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
