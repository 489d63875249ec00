#include "devices/device_address.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/devices/scanner.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

TEST(DeviceAddress, ReadsHostsAndPorts) {
  const DeviceAddress usual = parse_device_address("scip://192.168.0.10");
  EXPECT_EQ(usual.host, "192.168.0.10");
  EXPECT_EQ(usual.port, 10940);
  EXPECT_FALSE(usual.is_serial());
  const DeviceAddress other = parse_device_address("scip://laser.local:4000");
  EXPECT_EQ(other.host, "laser.local");
  EXPECT_EQ(other.port, 4000);
  const DeviceAddress six = parse_device_address("scip://[fe80::1]:10941");
  EXPECT_EQ(six.host, "fe80::1");
  EXPECT_EQ(six.port, 10941);
  EXPECT_EQ(parse_device_address("scip://[::1]").port, 10940);
}

TEST(DeviceAddress, ReadsSerialPorts) {
  const DeviceAddress plain = parse_device_address("scip:///dev/ttyACM0");
  EXPECT_TRUE(plain.is_serial());
  EXPECT_EQ(plain.path, "/dev/ttyACM0");
  EXPECT_EQ(plain.baud, 115200);
  const DeviceAddress full =
      parse_device_address("rplidar:///dev/ttyUSB0?baud=256000&mode=DenseBoost");
  EXPECT_EQ(full.protocol, DeviceProtocol::kRplidar);
  EXPECT_EQ(full.path, "/dev/ttyUSB0");
  EXPECT_EQ(full.baud, 256000);
  EXPECT_EQ(full.mode, "DenseBoost");
}

TEST(DeviceAddress, SaysWhatIsWrongAndHowItIsWritten) {
  const std::pair<const char*, const char*> cases[] = {
      {"tcp://1.2.3.4:1", "no scanner's address"},
      {"scip:/dev/ttyACM0", "lacks //"},
      {"scip://", "names neither"},
      {"scip://:10940", "names neither"},
      {"scip://host:0", "port"},
      {"scip://host:65536", "port"},
      {"scip://host:12x", "port"},
      {"scip://[::1", "bracket"},
      {"scip://[::1]x", "port"},
      {"rplidar://host", "no port"},
      {"scip:///dev/ttyACM0?baud=fast", "baud is no rate"},
      {"scip:///dev/ttyACM0?baud=12", "baud is no rate"},
      {"scip:///dev/ttyACM0?mode=express", "'mode=express' means nothing here"},
      {"scip://host?baud=9600", "'baud=9600' means nothing here"},
      {"rplidar:///dev/ttyUSB0?mode=", "'mode=' means nothing here"},
  };
  for (const auto& [text, words] : cases) {
    try {
      (void)parse_device_address(text);
      ADD_FAILURE() << text << " was taken";
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words));
      EXPECT_THAT(error.what(), HasSubstr(text));
      EXPECT_THAT(error.what(), HasSubstr("scip:///dev/ttyACM0?baud=115200"));
    }
  }
}

TEST(DeviceAddress, IsToldFromFiles) {
  EXPECT_TRUE(is_scanner_address("scip://1.2.3.4"));
  EXPECT_TRUE(is_scanner_address("rplidar:///dev/ttyUSB0"));
  EXPECT_FALSE(is_scanner_address("scip.log"));
  EXPECT_FALSE(is_scanner_address("drives/rplidar:1"));
}

}  // namespace
}  // namespace loopstone
