#include "loopstone/pipeline/cut_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "loopstone/base/error.hpp"
#include "support/memory_log.hpp"

namespace loopstone {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

LaserScan scan_at(double seconds) {
  LaserScan scan{.stamp = Stamp::from_seconds(100.0 + seconds),
                 .angle_min_rad = -1.0,
                 .angle_increment_rad = 0.01,
                 .range_min_m = 0.1,
                 .range_max_m = 30.0};
  for (int i = 0; i < 201; ++i) scan.ranges_m.push_back(2.0F + 0.01F * static_cast<float>(i));
  scan.robot_T_lidar = Pose2{0.2, 0.0, 0.0};
  return scan;
}

/// Odometry, then `count` scans, one a second.
std::vector<SensorMessage> drive(int count) {
  std::vector<SensorMessage> messages;
  for (int i = 0; i < count; ++i) {
    messages.emplace_back(OdometryPose{Stamp::from_seconds(100.0 + i), Pose2{0.1 * i, 0.0, 0.0}});
    messages.emplace_back(scan_at(i));
  }
  return messages;
}

/// Seconds since the log began.
std::vector<double> scans_of(CutLog& log) {
  std::vector<double> seconds;
  while (const auto message = log.next()) {
    if (std::holds_alternative<LaserScan>(*message))
      seconds.push_back(stamp_of(*message).seconds() - 100.0);
  }
  return seconds;
}

std::vector<double> scans_in(const LogCut& cut) {
  test::MemoryLog reader(drive(10));
  CutLog log(reader, cut, true, "reading");
  return scans_of(log);
}

TEST(CutLog, GivesThePartThatIsAskedFor) {
  EXPECT_EQ(scans_in({}).size(), 10U);
  EXPECT_THAT(scans_in({.start_s = 7.0}), ElementsAre(7.0, 8.0, 9.0));
  EXPECT_THAT(scans_in({.start_s = 2.0, .duration_s = 2.0}), ElementsAre(2.0, 3.0, 4.0));
  EXPECT_THAT(scans_in({.max_scans = 2}), ElementsAre(0.0, 1.0));
  EXPECT_THAT(scans_in({.start_s = 11.0}), IsEmpty());
}

TEST(CutLog, OdometryBeforeTheStartIsKept) {
  test::MemoryLog reader(drive(10));
  CutLog log(reader, {.start_s = 7.0}, true, "reading");
  const auto first = log.next();
  ASSERT_TRUE(first && std::holds_alternative<OdometryPose>(*first));
  EXPECT_EQ(stamp_of(*first), Stamp::from_seconds(100.0));
}

TEST(CutLog, AGivenRobotBeatsMountsOfScans) {
  for (const bool from_log : {true, false}) {
    test::MemoryLog reader({scan_at(0.0)});
    CutLog log(reader, {}, from_log, "reading");
    const auto message = log.next();
    ASSERT_TRUE(message);
    EXPECT_EQ(std::get<LaserScan>(*message).robot_T_lidar.has_value(), from_log);
  }
}

TEST(CutLog, TellsHowFarItIsAndStopsWhenItIsTold) {
  test::MemoryLog reader(drive(10));
  std::vector<std::int64_t> scans;
  std::string step;
  CutLog log(reader, {}, true, "reading", {.progress = [&](const Progress& progress) {
               scans.push_back(progress.scans);
               step = progress.step;
               EXPECT_EQ(progress.total, 20);
               return progress.scans < 3;
             }});
  EXPECT_THAT(scans_of(log), ElementsAre(0.0, 1.0, 2.0)) << "the one that it was told at is used";
  EXPECT_THAT(scans, ElementsAre(1, 2, 3));
  EXPECT_EQ(step, "reading");
  EXPECT_TRUE(log.interrupted());
  EXPECT_EQ(log.scans(), 3);
}

TEST(CutLog, StopsBetweenScansToo) {
  test::MemoryLog reader(drive(10));
  int asked = 0;
  CutLog log(reader, {}, true, "reading", {.stop = [&] { return ++asked == 5; }});
  int messages = 0;
  while (log.next()) ++messages;
  EXPECT_EQ(messages, 5);
  EXPECT_TRUE(log.interrupted());
}

TEST(CutLog, ALogWithoutAScanInTheCutIsAnErrorUnlessItWasCalledOff) {
  test::MemoryLog reader(drive(10));
  CutLog log(reader, {.start_s = 20.0}, true, "reading");
  EXPECT_THAT(scans_of(log), IsEmpty());
  try {
    (void)log.judge("drive.log");
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("drive.log: there is no laser scan in it after --start"));
  }
  test::MemoryLog called_off(drive(10));
  CutLog none(called_off, {.start_s = 20.0}, true, "reading", {.stop = [] { return true; }});
  EXPECT_THAT(scans_of(none), IsEmpty());
  EXPECT_NO_THROW((void)none.judge("drive.log"));
}

TEST(CutLog, WarningsAreTheTextsOfSuchFindings) {
  LogSummary summary;
  summary.findings = {{Severity::kNote, "a note"}, {Severity::kWarning, "a warning"}};
  EXPECT_THAT(warnings_of(summary), ElementsAre("a warning"));
}

}  // namespace
}  // namespace loopstone
