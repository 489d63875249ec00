#include <gtest/gtest.h>

#include <variant>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

LaserScan scan_at(double seconds) {
  return {.stamp = Stamp::from_seconds(seconds),
          .angle_min_rad = -0.5,
          .angle_increment_rad = 0.5,
          .range_min_m = 0.1,
          .range_max_m = 30.0,
          .ranges_m = {1.0F, 2.5F, 3.0F},
          .intensities = {100.0F, 2000.5F, static_cast<float>(seconds)}};
}

std::vector<LaserScan> scans_of(const std::string& path, bool intensities) {
  std::vector<LaserScan> scans;
  const auto log = open_log(path, {.intensities = intensities});
  while (const auto message = log->next()) {
    if (const auto* scan = std::get_if<LaserScan>(&*message)) scans.push_back(*scan);
  }
  return scans;
}

TEST(Intensities, SurviveInEveryFormatThatHoldsThemAndComeWhenAskedFor) {
  int formats = 0;
  for (const LogFormat& format : log_formats()) {
    if (!format.can_be_written()) continue;
    const test::TempDir folder;
    const std::string path = folder / "log";
    const auto writer = create_log({&format, path}, RobotModel{});
    for (int i = 0; i < 20; ++i) writer->write(scan_at(100.0 + 0.1 * i));
    writer->finish();
    EXPECT_EQ(scans_of(path, false).size(), 20U) << format.name;
    for (const LaserScan& scan : scans_of(path, false)) EXPECT_TRUE(scan.intensities.empty());
    const auto scans = scans_of(path, true);
    ASSERT_EQ(scans.size(), 20U);
    for (int i = 0; i < 20; ++i) {
      const auto wanted = scan_at(100.0 + 0.1 * i).intensities;
      EXPECT_EQ(scans[static_cast<std::size_t>(i)].intensities,
                format.holds.intensities ? wanted : std::vector<float>{})
          << format.name;
    }
    formats += format.holds.intensities ? 1 : 0;
  }
  EXPECT_EQ(formats, 3) << "MCAP, ROS 1 bags, rosbag2";
}

}  // namespace
}  // namespace loopstone
