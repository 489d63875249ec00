#include "loopstone/sensor/log_digest.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loopstone/sensor/messages.hpp"

namespace loopstone {
namespace {

TEST(LogDigest, TellsLogsApartByTheirMessages) {
  const auto digest = [](const std::vector<SensorMessage>& messages) {
    LogDigest result;
    for (const SensorMessage& message : messages) result.add(message);
    return result;
  };
  LaserScan scan{.stamp = Stamp{5}, .ranges_m = {1.0F, 2.0F}};
  const OdometryPose pose{Stamp{5}, {1.0, 2.0, 3.0}};
  const std::vector<SensorMessage> log{scan, pose};
  EXPECT_EQ(digest(log), digest(log));
  EXPECT_EQ(digest(log).messages(), 2);
  EXPECT_NE(digest(log), digest({scan}));
  EXPECT_NE(digest(log), digest({pose, scan}));
  scan.ranges_m[1] = 2.0001F;
  EXPECT_NE(digest(log), digest({scan, pose}));
  // A folder may have moved; a picture's stamp is what it is known by.
  const RgbdFrame frame{Stamp{7}, Stamp{8}, "a/1.png", "a/2.png"};
  EXPECT_EQ(digest({frame}), digest({RgbdFrame{Stamp{7}, Stamp{8}, "b/1.png", "b/2.png"}}));
  EXPECT_NE(digest({frame}), digest({RgbdFrame{Stamp{7}, Stamp{9}, "a/1.png", "a/2.png"}}));
}

}  // namespace
}  // namespace loopstone
