#include "loopstone/formats/log_scan.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/base/error.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

/// Ten scans, half a second apart from 1000 s on, of a robot that drives 0.1 m a scan.
std::string log() {
  std::string text;
  for (int i = 0; i < 10; ++i) {
    text += fmt::format("FLASER 5 {} 2 3 4 5 {:.1f} 0 0 {:.1f} 0 0 {:.3f} host {:.3f}\n", 1 + i,
                        0.1 * i, 0.1 * i, 1000.0 + 0.5 * i, 1000.0 + 0.5 * i);
  }
  return text;
}

std::string error_of(const std::string& name) {
  try {
    (void)read_log_scan(*parse_scan_name(name), RobotModel{});
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

TEST(LogScan, ByNumberAndByTime) {
  const test::TempDir folder;
  const std::string path = folder.write("a.clf", log());
  for (const char* name : {"#3", "@1001.5", "@1001.7", "@+1.5", "@+1.3"}) {
    const LogScan scan = read_log_scan(*parse_scan_name(path + name), RobotModel{});
    EXPECT_EQ(scan.index, 3) << name;
    EXPECT_EQ(scan.scan.stamp.nanoseconds, 1'001'500'000'000) << name;
    EXPECT_FLOAT_EQ(scan.scan.ranges_m[0], 4.0F) << name;
    ASSERT_TRUE(scan.odom_T_robot);
    EXPECT_NEAR(scan.velocity.x(), 0.2, 1e-9) << "0.1 m in half a second";
  }
  EXPECT_EQ(read_log_scan(*parse_scan_name(path + "#0"), RobotModel{}).velocity,
            Tangent2(Tangent2::Zero()));
  EXPECT_EQ(read_log_scan(*parse_scan_name(path + "#9"), RobotModel{}).index, 9);
}

TEST(LogScan, WhatIsNotThereIsNamed) {
  const test::TempDir folder;
  const std::string path = folder.write("a.clf", log());
  EXPECT_THAT(error_of(path + "#10"), HasSubstr("has no scan 10: it has 10, numbered from 0"));
  EXPECT_THAT(error_of(path + "@20"), HasSubstr("its scans go from 1000.000000000 to 1004.5"));
  EXPECT_THAT(error_of(path + "@+5.1"), HasSubstr("within half a second"));
}

TEST(LogScan, NamesAreToldFromPaths) {
  const test::TempDir folder;
  const std::string path = folder.write("a.clf", log());
  EXPECT_FALSE(parse_scan_name(path));
  EXPECT_FALSE(parse_scan_name(folder / "none.clf#3"));
  EXPECT_THROW((void)parse_scan_name(path + "#x"), UsageError);
  EXPECT_THROW((void)parse_scan_name(path + "#-1"), UsageError);
  EXPECT_THROW((void)parse_scan_name(path + "@soon"), UsageError);
  const std::string odd = folder.write("b#2", log());
  EXPECT_FALSE(parse_scan_name(odd)) << "a file of that very name";
  const auto of_odd = parse_scan_name(odd + "#5");
  ASSERT_TRUE(of_odd);
  EXPECT_EQ(of_odd->log, odd);
  // A set of a folder, then a scan of it.
  const auto of_set = parse_scan_name(folder.path().string() + "#20#7");
  ASSERT_TRUE(of_set);
  EXPECT_EQ(of_set->log, folder.path().string() + "#20");
  EXPECT_EQ(of_set->index, 7);
}

}  // namespace
}  // namespace loopstone
