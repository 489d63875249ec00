#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "loopstone/formats/convert_log.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "source_folder.hpp"
#include "support/pose_near.hpp"
#include "support/read_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::LogContent;
using test::pose_near;
using test::TempDir;

/// A robot on a curve: encoders at 40 Hz, gyro at 100 Hz, laser at 10 Hz; some beams bad, some
/// without a return.
std::vector<SensorMessage> drive(bool poses, std::size_t beams, double angle_min,
                                 double increment) {
  std::vector<SensorMessage> messages;
  for (int ms = 0; ms < 3000; ms += 5) {
    const Stamp stamp{1'300'000'000'000'000'000 + std::int64_t{ms} * 1'000'000};
    if (ms % 25 == 0 && !poses) messages.emplace_back(WheelTicks{stamp, {10, 9, 10, 9}});
    if (ms % 25 == 0 && poses) {
      messages.emplace_back(OdometryPose{stamp, {0.001 * ms, 0.0005 * ms, 0.0002 * ms}});
    }
    if (ms % 10 == 0 && !poses) {
      messages.emplace_back(ImuSample{stamp, {0.0, 0.0, 0.1}, {0.0, 0.0, 9.80665}});
    }
    if (ms % 100 == 0) {
      LaserScan scan;
      scan.stamp = stamp;
      scan.angle_min_rad = angle_min;
      scan.angle_increment_rad = increment;
      scan.range_min_m = 0.0;
      scan.range_max_m = 30.0;
      for (std::size_t i = 0; i < beams; ++i) {
        scan.ranges_m.push_back(1.0F + 0.013F * static_cast<float>(i) +
                                0.0001F * static_cast<float>(ms));
      }
      scan.ranges_m[1] = std::numeric_limits<float>::infinity();
      scan.ranges_m[2] = std::numeric_limits<float>::quiet_NaN();
      messages.emplace_back(std::move(scan));
    }
  }
  return messages;
}

void write_log(const std::string& path, const std::string& format,
               const std::vector<SensorMessage>& messages) {
  const auto writer = create_log(path, format, RobotModel{});
  for (const SensorMessage& message : messages) writer->write(message);
  writer->finish();
}

void expect_same_ranges(const LaserScan& a, const LaserScan& b) {
  ASSERT_EQ(a.ranges_m.size(), b.ranges_m.size());
  for (std::size_t i = 0; i < a.ranges_m.size(); ++i) {
    if (std::isnan(a.ranges_m[i])) {
      EXPECT_TRUE(std::isnan(b.ranges_m[i])) << i;
    } else {
      EXPECT_EQ(a.ranges_m[i], b.ranges_m[i]) << i;
    }
  }
}

class CarmenRoundTrip : public testing::TestWithParam<const char*> {};

TEST_P(CarmenRoundTrip, BringsEveryMessageBack) {
  const TempDir folder;
  for (const std::size_t beams : {std::size_t{181}, std::size_t{1081}}) {
    const bool half = beams == 181;
    const auto messages =
        drive(true, beams, half ? -kPi / 2 : -2.356, half ? radians(1.0) : 0.00436);
    const std::string path = folder / GetParam();
    write_log(path, "carmen", messages);
    const LogContent log = test::read_log(path);
    ASSERT_EQ(log.messages.size(), messages.size());
    EXPECT_EQ(log.skipped, 0);
    for (std::size_t i = 0; i < messages.size(); ++i) {
      EXPECT_EQ(stamp_of(log.messages[i]), stamp_of(messages[i]));
      if (const auto* pose = std::get_if<OdometryPose>(&messages[i])) {
        EXPECT_EQ(std::get<OdometryPose>(log.messages[i]).odom_T_robot, pose->odom_T_robot);
      } else {
        const auto& scan = std::get<LaserScan>(messages[i]);
        const auto& read = std::get<LaserScan>(log.messages[i]);
        expect_same_ranges(scan, read);
        EXPECT_NEAR(read.angle_min_rad, scan.angle_min_rad, 1e-12);
        EXPECT_NEAR(read.angle_increment_rad, scan.angle_increment_rad, 1e-12);
        EXPECT_DOUBLE_EQ(read.range_max_m, 30.0);
        EXPECT_TRUE(
            pose_near(*read.robot_T_lidar, RobotModel{}.lidars[0].robot_T_lidar, 1e-5, 1e-5));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Names, CarmenRoundTrip, testing::Values("a.clf", "a.clf.gz", "a.log.bz2"));

TEST(UcsdLog, RoundTripBringsEveryMessageBack) {
  const TempDir folder;
  const auto messages = drive(false, 1081, -2.356, 0.00436);
  write_log(folder / "log", "ucsd", messages);
  const LogContent log = test::read_log(folder / "log");
  ASSERT_EQ(log.messages.size(), messages.size());
  EXPECT_TRUE(log.in_time_order);
  std::size_t scan = 0;
  for (const SensorMessage& message : messages) {
    // A double holds a quarter of a microsecond at this time.
    EXPECT_NEAR(stamp_of(message).seconds(), stamp_of(log.messages[0]).seconds(), 4.0);
    if (const auto* wanted = std::get_if<LaserScan>(&message)) {
      expect_same_ranges(*wanted, log.scans[scan]);
      EXPECT_LT(std::abs((wanted->stamp - log.scans[scan].stamp).nanoseconds), 500);
      ++scan;
    }
  }
  ASSERT_FALSE(log.ticks.empty());
  EXPECT_EQ(log.ticks[0].counts, (std::array<std::int64_t, 4>{10, 9, 10, 9}));
  EXPECT_NEAR(log.imu[0].linear_acceleration_m_s2.z(), 9.80665, 1e-12);
  EXPECT_NEAR(log.imu[0].angular_velocity_rad_s.z(), 0.1, 1e-15);
}

TEST(UcsdLog, OdometryAndMountComeBack) {
  const TempDir folder;
  auto messages = drive(true, 20, -1.0, 0.1);
  for (SensorMessage& message : messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) scan->robot_T_lidar = Pose2{0.2, 0.1, 0.3};
  }
  write_log(folder / "log", "ucsd", messages);
  const LogContent log = test::read_log(folder / "log#20");
  EXPECT_EQ(log.messages.size(), messages.size());
  EXPECT_EQ(log.scans.at(0).robot_T_lidar, (Pose2{0.2, 0.1, 0.3}));
}

TEST(UcsdLog, NothingIsLeftWithoutFinish) {
  const TempDir folder;
  {
    const auto writer = create_log(folder / "log", "ucsd", RobotModel{});
    for (const SensorMessage& message : drive(false, 20, -1.0, 0.1)) writer->write(message);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / "log"));
  { const auto writer = create_log(folder / "a.clf", "carmen", RobotModel{}); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.clf"));
}

TEST(UcsdLog, DifferentBeamsCanNotBeWritten) {
  const TempDir folder;
  const auto writer = create_log(folder / "log", "ucsd", RobotModel{});
  LaserScan scan;
  scan.range_max_m = 30.0;
  scan.ranges_m = {1.0F, 2.0F};
  writer->write(scan);
  scan.ranges_m.push_back(3.0F);
  EXPECT_THROW(writer->write(scan), DataError);
}

TEST(ConvertLog, WheelsBecomePosesForCarmen) {
  const TempDir folder;
  write_log(folder / "log", "ucsd", drive(false, 181, -kPi / 2, radians(1.0)));
  const auto log = open_log(folder / "log");
  const auto writer = create_log(folder / "a.clf", "carmen", RobotModel{});
  const ConvertResult result = convert_log(*log, *writer, log_format("carmen").holds, RobotModel{});
  writer->finish();
  EXPECT_GT(result.poses_by_dead_reckoning, 100);
  const LogContent read = test::read_log(folder / "a.clf");
  EXPECT_EQ(read.scans.size(), 30u);
  EXPECT_GT(read.odometry.back().odom_T_robot.x, 1.0);
}

void expect_refused(const std::string& path, const std::string& reason) {
  try {
    (void)test::read_log(path);
    FAIL() << path << " was read";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
  }
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

TEST(BadLogs, MissingEmptyFolderAndForeign) {
  const TempDir folder;
  expect_refused(folder / "nothing.clf", "no such file");
  expect_refused(folder.write("empty.clf", ""), "empty");
  expect_refused(folder.path().string(), "EncodersN.npz");
  expect_refused(folder.write("a.log", "\x89PNG\r\n"), "a picture");
  expect_refused(folder.write("a.bag", "#ROSBAG V1.2\n"), "ROS bag of version 1");
  expect_refused(folder.write("noise.clf", std::string("\x07\x00\xff\x13", 4) + "noise"), "CARMEN");
}

TEST(BadLogs, TruncatedArchivesAndCompressedFiles) {
  const TempDir folder;
  const auto messages = drive(true, 181, -kPi / 2, radians(1.0));
  for (const char* const name : {"a.clf.gz", "b.clf.bz2"}) {
    write_log(folder / name, "carmen", messages);
    const std::string bytes = bytes_of(folder / name);
    expect_refused(folder.write(name, bytes.substr(0, bytes.size() / 2)), "cut off");
    std::string damaged = bytes;
    for (std::size_t i = bytes.size() / 3; i < bytes.size() / 3 + 40; ++i) damaged[i] ^= 0x5a;
    EXPECT_THROW((void)test::read_log(folder.write(name, damaged)), DataError);
  }
  write_log(folder / "log", "ucsd", drive(false, 20, -1.0, 0.1));
  const std::string hokuyo = folder / "log/Hokuyo20.npz";
  const std::string bytes = bytes_of(hokuyo);
  std::filesystem::resize_file(hokuyo, bytes.size() / 2);
  expect_refused(folder / "log", "Hokuyo20.npz");
}

TEST(BadLogs, SetsAreNamed) {
  const TempDir folder;
  const auto messages = drive(false, 20, -1.0, 0.1);
  for (const int set : {3, 7}) {
    const auto writer = create_log(folder / "log", "ucsd", RobotModel{}, set);
    for (const SensorMessage& message : messages) writer->write(message);
    writer->finish();
  }
  EXPECT_THROW((void)open_log(folder / "log"), UsageError);
  EXPECT_THROW((void)open_log(folder / "log#4"), UsageError);
  EXPECT_THROW((void)open_log(folder / "log#x"), UsageError);
  EXPECT_EQ(test::read_log(folder / "log#7").scans.size(), 30u);
  EXPECT_EQ(test::read_log(folder / "log/Hokuyo3.npz").scans.size(), 30u);
}

TEST(BadLogs, ASensorMayBeMissing) {
  const TempDir folder;
  write_log(folder / "log", "ucsd", drive(false, 20, -1.0, 0.1));
  std::filesystem::remove(folder / "log/Hokuyo20.npz");
  const LogContent log = test::read_log(folder / "log");
  EXPECT_TRUE(log.scans.empty());
  EXPECT_FALSE(log.ticks.empty());
  EXPECT_TRUE(log.has_note("Hokuyo20.npz"));
  std::filesystem::remove(folder / "log/Encoders20.npz");
  expect_refused(folder / "log", "neither laser scans nor wheel counts");
}

TEST(LogSummary, TellsWhatIsThere) {
  const TempDir folder;
  write_log(folder / "log", "ucsd", drive(false, 20, -1.0, 0.1));
  const auto log = open_log(folder / "log");
  const LogSummary summary = analyse_log(*log);
  ASSERT_EQ(summary.lidars.size(), 1u);
  EXPECT_EQ(summary.lidars[0].timing.records, 30);
  EXPECT_NEAR(summary.lidars[0].timing.rate_hz, 10.0, 1e-3);
  EXPECT_EQ(summary.lidars[0].ranges.no_return, 30);
  EXPECT_EQ(summary.lidars[0].ranges.bad, 30);
  EXPECT_EQ(summary.lidars[0].ranges.total(), 600);
  EXPECT_NEAR(summary.imu->median_acceleration_m_s2, 9.80665, 1e-5);
  EXPECT_NEAR(summary.wheels->timing.rate_hz, 40.0, 1e-3);
}

TEST(LogSummary, FindsWhatIsSuspicious) {
  const TempDir folder;
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += "FLASER 5 2 2 2 2 2 0 0 0 0 0 0 " + std::to_string(i) + ".0 h 0\n";
  }
  const auto log = open_log(folder.write("a.clf", text));
  const LogSummary summary = analyse_log(*log);
  EXPECT_EQ(summary.worst(), Severity::kError);
  std::string all;
  for (const Finding& finding : summary.findings) all += finding.text + "\n";
  EXPECT_NE(all.find("all ranges are 2.00 m"), std::string::npos) << all;
  EXPECT_NE(all.find("never changes"), std::string::npos) << all;
  EXPECT_NE(all.find("repeat the one before"), std::string::npos) << all;
}

std::string data(const std::string& name) {
  const char* const folder = std::getenv("LOOPSTONE_DATA");
  return (folder != nullptr ? std::string(folder) : LOOPSTONE_SOURCE_DIR "/../shared/data") + "/" +
         name;
}

TEST(RecordedLogs, IntelGivesEveryScan) {
  const std::string path = data("carmen/intel.clf");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const auto log = open_log(path);
  const LogSummary summary = analyse_log(*log);
  EXPECT_EQ(summary.lidars.at(0).timing.records, 13631);
  EXPECT_EQ(summary.odometry->timing.records, 13631 + 26915);
  EXPECT_EQ(summary.lidars[0].ranges.no_return, 68313);
  EXPECT_EQ(summary.left_out.skipped.records, 0);
  EXPECT_EQ(summary.lidars[0].robot_T_lidar, Pose2{});
}

TEST(RecordedLogs, AcesKnowsItsOwnNoReturn) {
  const std::string path = data("carmen/aces.clf");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const auto log = open_log(path);
  const LogSummary summary = analyse_log(*log);
  EXPECT_EQ(summary.lidars.at(0).timing.records, 7374);
  EXPECT_EQ(summary.lidars[0].ranges.no_return, 11139);
  EXPECT_NEAR(summary.odometry->path_length_m, 325.0, 1.0);
}

TEST(RecordedLogs, UcsdSensors) {
  const std::string path = data("ucsd/sensors#20");
  if (!std::filesystem::exists(data("ucsd/sensors"))) GTEST_SKIP() << path << " is not here";
  const LogContent log = test::read_log(path);
  EXPECT_EQ(log.ticks.size(), 4956u);
  EXPECT_EQ(log.imu.size(), 12187u);
  EXPECT_TRUE(log.in_time_order);
  EXPECT_NEAR(log.imu[0].linear_acceleration_m_s2.z(), 1.0219993 * 9.80665, 1e-4);
}

}  // namespace
}  // namespace loopstone
