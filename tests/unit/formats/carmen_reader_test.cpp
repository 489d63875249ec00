#include "formats/carmen_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "loopstone/formats/truth_log.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"
#include "support/read_log.hpp"
#include "support/temp_dir.hpp"

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

/// Reads with stamps of one kind; what the reader warns of is among the notes.
LogContent read_by(const std::string& text, StampUse stamps) {
  std::vector<std::string> warnings;
  LogContent content;
  LogOptions options;
  options.stamps = stamps;
  options.on_problem = [&](const Problem& problem) { content.problems.push_back(problem); };
  const auto log = read_carmen_log(text, options, "test.clf");
  while (auto message = log->next()) content.add(std::move(*message));
  content.notes = log->notes();
  for (const std::string& warning : log->warnings()) content.notes.push_back(warning);
  content.skipped = log->records_skipped();
  return content;
}

/// Scans at the header's and the logger's times, a line of odometry after each.
std::string scans_at(const std::vector<double>& header, const std::vector<double>& logger) {
  std::string text;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::string x = std::to_string(0.1 * static_cast<double>(i));
    const std::string times = std::to_string(header[i]) + " host " + std::to_string(logger[i]);
    text += "FLASER 4 1 2 3 4 " + x + " 0 0 " + x + " 0 0 " + times + "\n";
    text += "ODOM " + x + " 0 0 0 0 0 " + times + "\n";
  }
  return text;
}

std::vector<double> steps(std::size_t count, double step_s, double start_s = 0.0) {
  std::vector<double> times;
  for (std::size_t i = 0; i < count; ++i) {
    times.push_back(start_s + step_s * static_cast<double>(i));
  }
  return times;
}

/// Every scan is there, in the order of the file, a period apart.
void expect_made_up(const LogContent& log, std::size_t scans, double rate_hz) {
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.in_time_order);
  ASSERT_EQ(log.scans.size(), scans);
  EXPECT_EQ(log.odometry.size(), 2 * scans);
  for (std::size_t i = 0; i < scans; ++i) {
    EXPECT_NEAR(log.scans[i].stamp.seconds(), static_cast<double>(i) / rate_hz, 1e-6) << i;
    const OdometryPose& of_scan = log.odometry[2 * i];
    EXPECT_EQ(of_scan.stamp, log.scans[i].stamp);
    EXPECT_NEAR(of_scan.odom_T_robot.x, 0.1 * static_cast<double>(i), 1e-6) << "file order";
    EXPECT_NEAR((log.odometry[2 * i + 1].stamp - of_scan.stamp).seconds(), 0.5 / rate_hz, 1e-6);
  }
}

TEST(CarmenStamps, OfOneMomentBecomeThoseOfTheOrderAtASicksRate) {
  const LogContent log = read_by(scans_at(steps(50, 0.0), steps(50, 0.0, 7.0)), StampUse::kAuto);
  expect_made_up(log, 50, 5.0);
  EXPECT_TRUE(log.has_note("all scans have the same stamp, and the logger's times are no better"));
  EXPECT_TRUE(log.has_note("5 scans a second (the usual rate of a SICK laser"));
}

TEST(CarmenStamps, ThatRunToAndFroBecomeThoseOfTheOrderAtTheirOwnRate) {
  std::vector<double> header = steps(60, 0.125, 1000.0);
  for (std::size_t i = 0; i < header.size(); ++i) header[i] += (i / 10) % 2 == 0 ? 0.0 : -300.0;
  const LogContent log = read_by(scans_at(header, steps(60, 0.0)), StampUse::kAuto);
  expect_made_up(log, 60, 8.0);
  EXPECT_TRUE(log.has_note("repeat or run to and fro"));
  EXPECT_TRUE(log.has_note("8 scans a second (the mean step of their stamps)"));
}

TEST(CarmenStamps, ThatRunBackwardsBecomeThoseOfTheOrder) {
  const LogContent log =
      read_by(scans_at(steps(60, -1.0, 1000.0), steps(60, 0.0)), StampUse::kAuto);
  expect_made_up(log, 60, 5.0);
}

TEST(CarmenStamps, ThatJumpAreReplacedByTheLoggersWhereThoseGoOn) {
  std::vector<double> header = steps(60, 0.125, 1000.0);
  for (std::size_t i = 0; i < header.size(); ++i) header[i] += (i / 10) % 2 == 0 ? 0.0 : -300.0;
  const LogContent log = read_by(scans_at(header, steps(60, 0.25, 5.0)), StampUse::kAuto);
  EXPECT_EQ(log.skipped, 0);
  ASSERT_EQ(log.scans.size(), 60u);
  EXPECT_NEAR(log.scans[59].stamp.seconds(), 5.0 + 59 * 0.25, 1e-9);
  EXPECT_TRUE(log.has_note("times at which the logger wrote them down are used instead"));
}

TEST(CarmenStamps, ThatAreAbsentBecomeThoseOfTheOrder) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const std::string x = std::to_string(0.1 * i);
    text += "FLASER 4 1 2 3 4 " + x + " 0 0 " + x + " 0 0\nODOM " + x + " 0 0 0 0 0\n";
  }
  const LogContent log = read_by(text, StampUse::kAuto);
  expect_made_up(log, 20, 5.0);
  EXPECT_TRUE(log.has_note("no scan has a stamp"));
}

TEST(CarmenStamps, ThatGoBackALittleOrJumpOnceStay) {
  std::vector<double> header = steps(60, 0.2, 1000.0);
  for (std::size_t i = 5; i < header.size(); i += 10) header[i] -= 0.9;
  for (std::size_t i = 30; i < header.size(); ++i) header[i] += 500.0;
  header[50] = 9e5;
  const LogContent log = read_by(scans_at(header, steps(60, 0.0)), StampUse::kAuto);
  EXPECT_EQ(log.scans.size(), 59u);
  EXPECT_NEAR(log.scans[0].stamp.seconds(), 1000.0, 1e-9);
  EXPECT_FALSE(log.has_note("order of the file, with stamps"));
}

TEST(CarmenStamps, AClockThatWasSetBackInALongLogIsSeen) {
  std::vector<double> header = steps(3000, 0.2, 5000.0);
  for (std::size_t i = 1500; i < header.size(); ++i) header[i] -= 4000.0;
  std::string text = scans_at(header, steps(3000, 0.0));
  ASSERT_GT(text.size(), 1u << 18) << "long enough to be looked at in places";
  expect_made_up(read_by(text, StampUse::kAuto), 3000, 5.0);
}

TEST(CarmenStamps, AreThoseThatAreAskedFor) {
  const std::string text = scans_at(steps(10, 0.5, 100.0), steps(10, 0.25, 3.0));
  EXPECT_NEAR(read_by(text, StampUse::kHeader).scans.at(4).stamp.seconds(), 102.0, 1e-9);
  EXPECT_NEAR(read_by(text, StampUse::kRecord).scans.at(4).stamp.seconds(), 4.0, 1e-9);
  const LogContent by_order = read_by(text, StampUse::kOrder);
  expect_made_up(by_order, 10, 2.0);
  EXPECT_TRUE(by_order.has_note("as asked for"));
  const std::string milliseconds = scans_at(steps(10, 500.0, 976052857337.0), steps(10, 0.25));
  EXPECT_THROW((void)read_by(milliseconds, StampUse::kAuto), DataError);
  expect_made_up(read_by(milliseconds, StampUse::kOrder), 10, 4.0);
  EXPECT_EQ(read_by(milliseconds, StampUse::kRecord).scans.size(), 10u);
}

TEST(CarmenStamps, OfALogOfOdometryAloneCanBeMadeUp) {
  std::string text;
  for (int i = 0; i < 30; ++i) text += odom("0.0");
  const LogContent log = read_by(text, StampUse::kOrder);
  ASSERT_EQ(log.odometry.size(), 30u);
  EXPECT_LT(log.odometry[28].stamp, log.odometry[29].stamp);
}

TEST(CarmenStamps, OfTheOrderKeepOneOfTwoReportsOfASweep) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    text += flaser("0.0", 4) +
            "ROBOTLASER1 0 -1.5 3 1 80 0.01 0 4 1 2 3 4 0 0 0 0 0 0 0 0 0 0 0 0 0.0 h 0\n";
  }
  const LogContent log = read_by(text, StampUse::kAuto);
  EXPECT_EQ(log.scans.size(), 20u);
  EXPECT_TRUE(log.has_note("20 scans were reported a second time"));
}

TEST(CarmenReader, EveryLaserHasItsIndexAndMount) {
  const auto robot_laser = [](int number, const std::string& laser_pose, const char* stamp) {
    return "ROBOTLASER" + std::to_string(number) + " 2 -1.5 3 1 5.6 0.01 0 4 1 2 3 4 0 " +
           laser_pose + " 1 0 0 0 0 0 0 0 " + stamp + " h 1\n";
  };
  const LogContent log =
      read(flaser("1.0", 4) + robot_laser(2, "0.7 0 3.1415926", "1.1") +
           "LASER3 4 1 2 3 4 1.2 h 1\n" + robot_laser(4, "1 0.3 1.5707963", "1.3") +
           "RAWLASER5 2 -1.5 3 1 5.6 0.01 0 4 1 2 3 4 0 1.4 h 1\n");
  EXPECT_EQ(log.skipped, 0);
  ASSERT_EQ(log.scans.size(), 5u);
  for (int lidar = 0; lidar < 5; ++lidar) {
    EXPECT_EQ(log.scans[static_cast<std::size_t>(lidar)].lidar, lidar);
  }
  EXPECT_TRUE(pose_near(log.scans[1].robot_T_lidar.value(), {-0.3, 0, kPi}, 1e-5, 1e-5));
  EXPECT_TRUE(pose_near(log.scans[3].robot_T_lidar.value(), {0, 0.3, kPi / 2}, 1e-5, 1e-5));
  EXPECT_FALSE(log.scans[2].robot_T_lidar);
  EXPECT_TRUE(log.has_note("does not tell where laser 3 sits"));
  EXPECT_TRUE(log.has_note("does not tell where laser 5 sits"));
  EXPECT_FALSE(log.has_note("not read"));
}

TEST(CarmenReader, ParamsMayPutALaserAsideAndTurned) {
  const LogContent log = read(
      "PARAM robot_frontlaser_offset 0.2 1 h 0\nPARAM robot_frontlaser_side_offset 0.1 1 h 0\n"
      "PARAM robot_frontlaser_angular_offset 0.5 1 h 0\n" +
      flaser("1.0"));
  EXPECT_TRUE(pose_near(log.scans.at(0).robot_T_lidar.value(), {0.2, 0.1, 0.5}, 1e-9, 1e-9));
}

TEST(CarmenTruth, IsReadByItsName) {
  const test::TempDir folder;
  std::string text;
  for (int i = 0; i < 6; ++i) {
    const std::string stamp = std::to_string(i) + ".0";
    text += flaser(stamp, 4) + "TRUEPOS " + std::to_string(i) + " 5 0.25 9 9 9 " + stamp + " h 0\n";
  }
  const std::string path = folder.write("log.clf", text);
  const Trajectory truth = read_truth(path, "TRUEPOS");
  ASSERT_EQ(truth.size(), 6u);
  EXPECT_EQ(truth.poses()[3].stamp, Stamp::from_seconds(3.0));
  EXPECT_TRUE(pose_near(truth.poses()[3].pose, {3.0, 5.0, 0.25}, 1e-12, 1e-12));
  const LogContent log = read(text);
  EXPECT_EQ(log.odometry.size(), 6u) << "true poses are no odometry";
  EXPECT_TRUE(log.has_note("6 lines of TRUEPOS"));
}

TEST(CarmenTruth, HasTheStampsOfTheMessagesAroundIt) {
  const test::TempDir folder;
  std::string text;
  for (int i = 0; i < 10; ++i) text += flaser("0.0", 4) + "TRUEPOS 1 2 0 0 0 0 0.0 h 0\n";
  const std::string path = folder.write("log.clf", text);
  const Trajectory truth = read_truth(path, "TRUEPOS");
  ASSERT_EQ(truth.size(), 10u);
  const LogContent log = test::read_log(path);
  ASSERT_EQ(log.scans.size(), 10u);
  EXPECT_NEAR((truth.poses()[4].stamp - log.scans[4].stamp).seconds(), 0.1, 1e-9);
}

TEST(CarmenTruth, WhatIsThereIsToldWhenItIsNot) {
  const test::TempDir folder;
  const auto refusal = [&](const std::string& text, const std::string& topic) -> std::string {
    try {
      (void)read_truth(folder.write("log.clf", text), topic);
    } catch (const DataError& error) {
      return error.what();
    }
    return {};
  };
  const std::string scan = flaser("1.0", 4);
  EXPECT_NE(refusal(scan, "TRUEPOS").find("there are none in it"), std::string::npos);
  EXPECT_NE(refusal(scan + "TRUEPOS 1 2 0 0 0 0 1.0 h 0\n", "/truth").find("there is TRUEPOS"),
            std::string::npos);
}

}  // namespace
}  // namespace loopstone
