#include "formats/carmen_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"
#include "support/read_log.hpp"

namespace loopstone {
namespace {

using test::LogContent;
using test::pose_near;

std::string flaser(const std::string& stamp, std::size_t beams = 180, double range = 2.5,
                   const std::string& poses = "1 2 0.5 1 2 0.5", const char* tag = "FLASER") {
  std::string line = std::string(tag) + " " + std::to_string(beams);
  for (std::size_t i = 0; i < beams; ++i) {
    line += " " + std::to_string(range + 0.001 * static_cast<double>(i));
  }
  return line + " " + poses + " " + stamp + " host 0.0\n";
}

std::string odom(const std::string& stamp, const std::string& pose = "1 2 0.5") {
  return "ODOM " + pose + " 0 0 0 " + stamp + " host 0.0\n";
}

LogContent read(const std::string& text) {
  return test::read_all(
      [&](const LogOptions& options) { return read_carmen_log(text, options, "test.clf"); });
}

TEST(CarmenReader, AScanComesAfterItsOdometryOfTheSameStamp) {
  const LogContent log = read(flaser("976052857.337530"));
  ASSERT_EQ(log.messages.size(), 2u);
  ASSERT_EQ(log.odometry.size(), 1u);
  EXPECT_EQ(log.odometry[0].stamp.nanoseconds, 976052857337530000);  // a double would lose digits
  EXPECT_EQ(log.scans[0].stamp, log.odometry[0].stamp);
  EXPECT_TRUE(std::holds_alternative<OdometryPose>(log.messages[0]));
  EXPECT_TRUE(pose_near(log.odometry[0].odom_T_robot, {1.0, 2.0, 0.5}, 1e-12, 1e-12));
}

TEST(CarmenReader, BeamAnglesFollowCarmensRule) {
  const struct {
    std::size_t beams;
    double first_deg;
    double last_deg;
  } cases[] = {{180, -90, 89}, {181, -90, 90},         {360, -90, 89.5}, {361, -90, 90},
               {401, -50, 50}, {400, -49.875, 49.875}, {100, -90, 90},   {541, -90.0, 90.0}};
  for (const auto& c : cases) {
    const LogContent log = read(flaser("1.0", c.beams));
    ASSERT_EQ(log.scans.size(), 1u) << c.beams;
    EXPECT_NEAR(degrees(log.scans[0].angle_rad(0)), c.first_deg, 1e-9) << c.beams;
    EXPECT_NEAR(degrees(log.scans[0].angle_rad(c.beams - 1)), c.last_deg, 1e-9) << c.beams;
  }
}

TEST(CarmenReader, ParamOverridesTheResolution) {
  const LogContent log =
      read("PARAM laser_front_laser_resolution 0.25 1.0 host 0\n" + flaser("1.0", 541));
  EXPECT_NEAR(degrees(log.scans[0].angle_increment_rad), 0.25, 1e-12);
  EXPECT_NEAR(degrees(log.scans[0].angle_rad(540)), 67.5, 1e-9);
}

TEST(CarmenReader, RobotLaserStatesItsBeamsAndPoses) {
  const LogContent log = read(
      "ROBOTLASER1 0 -1.5 3.0 1.0 20.0 0.01 0 4 1.5 20.0 0 nan 0 1.22 2 0 1 2 0 0 0 0 0 0 5.25 h "
      "1\n");
  ASSERT_EQ(log.scans.size(), 1u);
  const LaserScan& scan = log.scans[0];
  EXPECT_DOUBLE_EQ(scan.angle_min_rad, -1.5);
  EXPECT_DOUBLE_EQ(scan.angle_increment_rad, 1.0);
  EXPECT_DOUBLE_EQ(scan.range_max_m, 20.0);
  EXPECT_FLOAT_EQ(scan.ranges_m[0], 1.5F);
  EXPECT_TRUE(std::isinf(scan.ranges_m[1]));
  EXPECT_TRUE(std::isnan(scan.ranges_m[2]));
  EXPECT_TRUE(std::isnan(scan.ranges_m[3]));
  ASSERT_TRUE(scan.robot_T_lidar);
  EXPECT_TRUE(pose_near(*scan.robot_T_lidar, {0.22, 0.0, 0.0}, 1e-9, 1e-9));
}

TEST(CarmenReader, TheMountIsThatOfThePosesWhateverTheHeading) {
  // Laser 4 cm behind the base, as in fr079; heading 90 deg.
  const LogContent log = read(flaser("1.0", 180, 2.5, "3 0.96 1.5707963 3 1 1.5707963"));
  ASSERT_TRUE(log.scans[0].robot_T_lidar);
  EXPECT_TRUE(pose_near(*log.scans[0].robot_T_lidar, {-0.04, 0.0, 0.0}, 1e-4, 1e-4));
}

TEST(CarmenReader, CorrectedPosesAreNoMount) {
  std::string text;
  for (int i = 0; i < 30; ++i) {
    const std::string x = std::to_string(0.2 * i);
    text +=
        flaser(std::to_string(i) + ".0", 180, 2.5, x + " 0 0 " + std::to_string(0.3 * i) + " 0 0");
  }
  const LogContent log = read(text);
  EXPECT_TRUE(log.has_note("corrected"));
  ASSERT_TRUE(log.scans[20].robot_T_lidar);
  EXPECT_EQ(*log.scans[20].robot_T_lidar, Pose2{});
  EXPECT_DOUBLE_EQ(log.odometry[20].odom_T_robot.x, 6.0);  // the second pose
}

TEST(CarmenReader, BadRangesAreNanAndFarOnesAreNoReturns) {
  const LogContent log = read("FLASER 8 1.0 0 -3 nan inf 81.83 1e30 0.01 0 0 0 0 0 0 1.0 h 0\n");
  const auto& ranges = log.scans[0].ranges_m;
  EXPECT_FLOAT_EQ(ranges[0], 1.0F);
  for (const int bad : {1, 2, 3, 4, 6})
    EXPECT_TRUE(std::isnan(ranges[static_cast<std::size_t>(bad)])) << bad;
  EXPECT_TRUE(std::isinf(ranges[5]));
  EXPECT_FLOAT_EQ(ranges[7], 0.01F);
}

TEST(CarmenReader, AValueAloneAtTheTopIsNoReturn) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    text += "FLASER 180";
    for (int b = 0; b < 180; ++b) {
      text += b % 9 == i % 9 ? " 50.00" : " " + std::to_string(1.0 + 0.01 * ((b * 7 + i) % 300));
    }
    text += " 0 0 0 0 0 0 " + std::to_string(i) + ".5 h 0\n";
  }
  const LogContent log = read(text);
  EXPECT_TRUE(log.has_note("50.00"));
  EXPECT_TRUE(std::isinf(log.scans[0].ranges_m[0]));
  EXPECT_DOUBLE_EQ(log.scans[0].range_max_m, 50.0);
}

TEST(CarmenReader, AFarWallSeenFromStandstillIsAReturn) {
  std::string text;  // the same scan again and again: one beam sees farthest
  for (int i = 0; i < 100; ++i) text += flaser(std::to_string(i) + ".5", 180, 5.0);
  const LogContent log = read(text);
  EXPECT_TRUE(std::isfinite(log.scans[0].ranges_m[179]));
}

TEST(CarmenReader, StampsThatGoBackALittleArePutInOrder) {
  const LogContent log = read(flaser("10.0") + odom("10.2") + flaser("10.9") + flaser("10.3") +
                              odom("10.1") + flaser("11.2") + flaser("14.0"));
  EXPECT_TRUE(log.in_time_order);
  EXPECT_EQ(log.scans.size(), 5u);
  EXPECT_EQ(log.odometry.size(), 7u);
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.has_note("out of the order"));
}

TEST(CarmenReader, OdometryWithAnotherClockCostsNoScan) {
  std::string text;
  for (int i = 0; i < 6000; ++i) text += odom(std::to_string(1000000 + i) + ".0");
  for (int i = 0; i < 50; ++i) text += flaser(std::to_string(100 + i) + ".0", 10);
  const LogContent log = read(text);
  EXPECT_TRUE(log.in_time_order);
  EXPECT_EQ(log.scans.size(), 50u);
}

TEST(CarmenReader, OneStampFarAheadCostsOneScan) {
  std::string text = flaser("999999999.0", 10);
  for (int i = 0; i < 30; ++i) {
    text += flaser(std::to_string(100 + i) + ".0", 10);
    if (i == 15) text += flaser("500000.0", 10);
  }
  const LogContent log = read(text);
  EXPECT_EQ(log.scans.size(), 30u);
  ASSERT_EQ(log.problems.size(), 2u);
  EXPECT_EQ(log.problems[0].location.line, 1);
  EXPECT_EQ(log.problems[1].location.line, 18);
}

TEST(CarmenReader, ALongPauseIsNoBrokenStamp) {
  const LogContent log = read(flaser("10.0", 10) + flaser("10.2", 10) + flaser("500.0", 10) +
                              flaser("900.0", 10) + flaser("900.1", 10));
  EXPECT_EQ(log.scans.size(), 5u);
  EXPECT_EQ(log.skipped, 0);
}

TEST(CarmenReader, DuplicatesAreCountedAndSkipped) {
  const LogContent log = read(flaser("10.0") + flaser("10.0") + odom("11.0") + odom("11.0"));
  EXPECT_EQ(log.scans.size(), 1u);
  EXPECT_EQ(log.odometry.size(), 2u);
  EXPECT_EQ(log.skipped, 2);
}

TEST(CarmenReader, TheSameScanUnderTwoTagsComesOnce) {
  const std::string robot_laser =
      "ROBOTLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 ";
  const LogContent log = read(flaser("10.0", 3) + robot_laser + "10.0 h 0\n" + flaser("10.2", 3) +
                              robot_laser + "10.2 h 0\n");
  EXPECT_EQ(log.scans.size(), 2u);
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.has_note("second time"));
}

TEST(CarmenReader, OtherBeamsUnderAnotherTagAreAnotherScanUnlessOfTheSameMoment) {
  const std::string robot_laser =
      "ROBOTLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 ";
  const LogContent log = read(flaser("10.0", 5) + robot_laser + "10.1 h 0\n" + flaser("10.2", 5) +
                              robot_laser + "10.2 h 0\n" + robot_laser + "10.3 h 0\n");
  std::vector<std::size_t> beams;
  for (const LaserScan& scan : log.scans) beams.push_back(scan.ranges_m.size());
  EXPECT_EQ(beams, (std::vector<std::size_t>{5, 3, 5, 3}));
  EXPECT_TRUE(log.has_note("1 scans were reported a second time"));
}

TEST(CarmenReader, RearLaserAndMixedBeamCounts) {
  const LogContent log =
      read(flaser("1.0", 180) + flaser("1.0", 181, 2.0, "1 0 3.1415926 1 0 0", "RLASER") +
           flaser("2.0", 181));
  ASSERT_EQ(log.scans.size(), 3u);
  EXPECT_EQ(log.scans[1].lidar, 1);
  EXPECT_NEAR(std::abs(log.scans[1].robot_T_lidar->yaw), kPi, 1e-4);
  EXPECT_EQ(log.scans[2].ranges_m.size(), 181u);
}

TEST(CarmenReader, BrokenLinesAreNamedAndSkipped) {
  const std::string broken[] = {
      "FLASER 180 1 2 3 0 0 0 0 0 0 2.0 h 0\n",            // fewer ranges than beams
      "FLASER 2 1 2 3 0 0 0 0 0 0 2.0 h 0 0 0\n",          // more
      "FLASER 2 1 x 0 0 0 0 0 0 2.0 h 0\n",                // no number
      "FLASER -5 0 0 0 0 0 0 2.0 h 0\n",                   // impossible count
      "FLASER 999999999999 0 0 0 0 0 0 2.0 h 0\n",         //
      "FLASER 0 0 0 0 0 0 0 2.0 h 0\n",                    // no beams
      "FLASER 2 1 2 nan 0 0 0 0 0 2.0 h 0\n",              // pose
      "FLASER 2 1 2 0 0 0 0 0 0 nan h 0\n",                // stamp
      "FLASER 2 1 2 0 0 0 0 0 0 99999999999999999 h 0\n",  // stamp
      "ODOM 1 2\n",
      "ODOM 1 2 inf 0 0 0 2.0 h 0\n",
      "FLASER\n",
      std::string("\x01\xff\xfe garbage\n")};
  for (const std::string& line : broken) {
    const LogContent log = read(flaser("1.0") + line + flaser("3.0"));
    EXPECT_EQ(log.scans.size(), 2u) << line;
    ASSERT_EQ(log.problems.size(), 1u) << line;
    EXPECT_EQ(log.problems[0].location.line, 2) << line;
    EXPECT_EQ(log.skipped, 1) << line;
  }
}

TEST(CarmenReader, StrictMakesThemAnErrorWithItsLine) {
  LogOptions options;
  options.strict = true;
  const std::string text = flaser("1.0") + "ODOM 1 2\n";
  const auto log = read_carmen_log(text, options, "some.clf");
  try {
    while (log->next()) {
    }
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_EQ(error.location().line, 2);
    EXPECT_NE(std::string(error.what()).find("some.clf:2"), std::string::npos);
  }
}

TEST(CarmenReader, UnknownTagsAreCountedInTheNotes) {
  const LogContent log = read("# comment\n\nNEFF 12\nGPGGA x\n" + flaser("1.0"));
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.has_note("GPGGA"));
}

TEST(CarmenReader, RubbishIsRefused) {
  EXPECT_THROW((void)read("hello world\n"), DataError);
  EXPECT_THROW((void)read(std::string(100000, '\0')), DataError);
  EXPECT_THROW((void)read(""), DataError);
}

TEST(CarmenReader, AnEndlessLineIsSkipped) {
  const LogContent log =
      read(flaser("1.0") + "FLASER 3 " + std::string(5'000'000, '1') + "\n" + flaser("2.0"));
  EXPECT_EQ(log.scans.size(), 2u);
  ASSERT_EQ(log.problems.size(), 1u);
  EXPECT_EQ(log.problems[0].location.line, 2);
}

TEST(CarmenReader, LineEndsOfWindowsAndNoLastEnd) {
  std::string text = flaser("1.0");
  text.insert(text.size() - 1, "\r");
  std::string last = flaser("2.0");
  last.pop_back();
  EXPECT_EQ(read(text + last).scans.size(), 2u);
}

TEST(CarmenReader, LasersAreOnTheirRobotsAndRobotsOnTheEarth) {
  const LogContent far =
      read(flaser("1.0") + flaser("2.0", 180, 2.5, "4e9 2 0.5 1 2 0.5") + odom("3.0", "1e300 0 0"));
  EXPECT_EQ(far.scans.size(), 1u);
  ASSERT_EQ(far.problems.size(), 2u);
  EXPECT_NE(far.problems[0].reason.find("the laser's pose lies more than 10,000 km away"),
            std::string::npos);
  // A pose in another frame is no mount.
  const LogContent shifted = read(flaser("1.0", 180, 2.5, "500001 5000002 0.5 1 2 0.5"));
  ASSERT_EQ(shifted.scans.size(), 1u);
  EXPECT_TRUE(pose_near(shifted.scans[0].robot_T_lidar.value(), {}, 1e-9, 1e-9));
  const LogContent stated = read("PARAM robot_frontlaser_offset 4e9 1.0 host 0.0\n" +
                                 flaser("1.0", 180, 2.5, "1 2 0.5 1 2 0.5"));
  ASSERT_EQ(stated.scans.size(), 1u);
  EXPECT_TRUE(pose_near(stated.scans[0].robot_T_lidar.value(), {}, 1e-9, 1e-9));
}

}  // namespace
}  // namespace loopstone
