#include "formats/rawlog_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "formats/rawlog_objects.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/pose_near.hpp"
#include "support/read_log.hpp"
#include "support/recorded_data.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::LogContent;
using test::pose_near;

/// Bytes as MRPT writes them.
class Bytes {
 public:
  template <typename Number>
  Bytes& add(Number value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    text_.append(raw, sizeof value);
    return *this;
  }
  Bytes& add_float(double value) { return add(static_cast<float>(value)); }
  Bytes& add_count(std::size_t value) { return add(static_cast<std::uint32_t>(value)); }
  Bytes& add_text(const std::string& text) { return add_count(text.size()).add_raw(text); }
  Bytes& add_raw(const std::string& text) {
    text_ += text;
    return *this;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string object(const std::string& name, int version, const std::string& fields) {
  return std::string(1, static_cast<char>(0x80 + name.size())) + name +
         std::string(1, static_cast<char>(version)) + fields + "\x88";
}

/// As before MRPT 0.5.5.
std::string old_object(const std::string& name, int version, const std::string& fields) {
  return Bytes()
      .add(static_cast<std::uint32_t>(name.size()))
      .add_raw(name)
      .add(static_cast<std::int32_t>(version))
      .add_raw(fields)
      .text();
}

std::uint64_t ticks(double seconds) {
  return 116'444'736'000'000'000ULL + static_cast<std::uint64_t>(std::llround(seconds * 1e7));
}

std::string pose2(double x, double y, double yaw) {
  return object("CPose2D", 1, Bytes().add(x).add(y).add(yaw).text());
}

/// Of version 2: a quaternion, here of a turn about z and then about x.
std::string pose3(double x, double y, double yaw, double roll = 0.0) {
  const double w = std::cos(yaw / 2) * std::cos(roll / 2);
  const double qx = std::cos(yaw / 2) * std::sin(roll / 2);
  const double qy = std::sin(yaw / 2) * std::sin(roll / 2);
  const double qz = std::sin(yaw / 2) * std::cos(roll / 2);
  return object("CPose3D", 2, Bytes().add(x).add(y).add(0.3).add(w).add(qx).add(qy).add(qz).text());
}

/// Of version 3: a matrix, here of a turn about y.
std::string pitched_pose3(double pitch) {
  Bytes bytes;
  bytes.add(0.1).add(0.0).add(0.3);
  for (const double value : {std::cos(pitch), 0.0, std::sin(pitch), 0.0, 1.0, 0.0, -std::sin(pitch),
                             0.0, std::cos(pitch)}) {
    bytes.add(value);
  }
  return object("CPose3D", 3, bytes.text());
}

struct Sweep {
  double time_s = 0.0;
  int version = 7;
  std::string label = "FLASER";
  std::string pose = pose3(0.2, 0.0, 0.0);
  bool right_to_left = true;
  std::vector<double> ranges_m{1.0, 2.0, 3.0};
  std::vector<int> valid{1, 1, 1};
};

std::string matrix(std::uint32_t rows, std::uint32_t columns, const std::vector<double>& values) {
  Bytes bytes;
  bytes.add(rows).add(columns);
  for (const double value : values) bytes.add_float(value);
  return object("CMatrix", 0, bytes.text());
}

std::string scan_fields(const Sweep& sweep) {
  Bytes bytes;
  bytes.add_float(kPi).add(static_cast<std::uint8_t>(sweep.right_to_left)).add_float(25.0);
  bytes.add_raw(sweep.pose);
  if (sweep.version < 6) bytes.add_raw(matrix(6, 6, std::vector<double>(36, 0.0)));
  bytes.add_count(sweep.ranges_m.size());
  for (const double range_m : sweep.ranges_m) bytes.add_float(range_m);
  if (sweep.version >= 1) {
    for (const int valid : sweep.valid) bytes.add(static_cast<std::uint8_t>(valid));
  }
  if (sweep.version >= 2) bytes.add_float(0.01);
  if (sweep.version >= 3) bytes.add(sweep.time_s == 0.0 ? std::uint64_t{0} : ticks(sweep.time_s));
  if (sweep.version >= 4) bytes.add_float(0.0);
  if (sweep.version >= 5) bytes.add_text(sweep.label).add(0.0);
  if (sweep.version >= 7) bytes.add(std::uint8_t{0});
  return bytes.text();
}

std::string scan(const Sweep& sweep) {
  return object("mrpt::obs::CObservation2DRangeScan", sweep.version, scan_fields(sweep));
}

std::string odometry(double time_s, double x, int version = 2) {
  Bytes bytes;
  bytes.add_raw(pose2(x, 0.5, 0.25)).add_text("odometry").add(ticks(time_s));
  if (version == 1) bytes.add_raw(std::string(1 + 8 + 1 + 8, '\0'));
  if (version == 2) bytes.add_raw(std::string(2, '\0'));
  return object("mrpt::obs::CObservationOdometry", version, bytes.text());
}

std::string motion(double time_s, double x, int version = 6) {
  Bytes bytes;
  bytes.add(std::int32_t{0}).add_raw(pose2(x, 0.0, 0.0));
  const std::size_t model = version == 2 ? 44 : version == 3 ? 44 : version == 4 ? 48 : 56;
  bytes.add_raw(std::string(model, '\1'));
  bytes.add_raw(std::string(version >= 7 ? 2 : 18, '\0'));
  if (version >= 6) bytes.add(ticks(time_s));
  return object("CActionRobotMovement2D", version, bytes.text());
}

std::string collection(const std::vector<std::string>& actions) {
  Bytes bytes;
  bytes.add_count(actions.size());
  for (const std::string& action : actions) bytes.add_raw(action);
  return object("CActionCollection", 0, bytes.text());
}

std::string frame(const std::vector<std::string>& observations) {
  Bytes bytes;
  bytes.add_count(observations.size());
  for (const std::string& observation : observations) bytes.add_raw(observation);
  return object("CSensoryFrame", 2, bytes.text());
}

struct Content : LogContent {
  std::vector<std::string> warnings{};
};

Content read(const std::string& bytes, StampUse stamps = StampUse::kAuto) {
  Content content;
  LogOptions options;
  options.stamps = stamps;
  options.on_problem = [&](const Problem& problem) { content.problems.push_back(problem); };
  const auto log = read_rawlog(bytes, options, "test.rawlog");
  while (auto message = log->next()) content.add(std::move(*message));
  content.notes = log->notes();
  content.warnings = log->warnings();
  content.skipped = log->records_skipped();
  return content;
}

TEST(RawlogReader, ObservationsBecomeMessages) {
  const Content log = read(odometry(100.0, 1.5) + scan({.time_s = 100.1234567}));
  EXPECT_EQ(log.skipped, 0);
  ASSERT_EQ(log.odometry.size(), 1u);
  EXPECT_TRUE(pose_near(log.odometry[0].odom_T_robot, {1.5, 0.5, 0.25}, 1e-12, 1e-12));
  ASSERT_EQ(log.scans.size(), 1u);
  const LaserScan& sweep = log.scans[0];
  EXPECT_EQ(sweep.stamp.nanoseconds, 100'123'456'700);
  EXPECT_NEAR(sweep.angle_min_rad, -kPi / 2, 1e-6);
  EXPECT_NEAR(sweep.angle_increment_rad, kPi / 2, 1e-6);
  EXPECT_DOUBLE_EQ(sweep.range_max_m, 25.0);
  EXPECT_EQ(sweep.ranges_m, (std::vector<float>{1.0F, 2.0F, 3.0F}));
  EXPECT_TRUE(pose_near(sweep.robot_T_lidar.value(), {0.2, 0.0, 0.0}, 1e-9, 1e-9));
}

TEST(RawlogReader, ActionsAddUpToPoses) {
  const Content log = read(collection({motion(100.0, 0.5)}) + frame({scan({.time_s = 100.1})}) +
                           collection({motion(100.2, 0.25)}) + frame({scan({.time_s = 100.3})}));
  EXPECT_EQ(log.skipped, 0);
  ASSERT_EQ(log.odometry.size(), 2u);
  EXPECT_TRUE(pose_near(log.odometry[1].odom_T_robot, {0.75, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_EQ(log.odometry[1].stamp, Stamp::from_seconds(100.2));
  EXPECT_EQ(log.scans.size(), 2u);
}

TEST(RawlogReader, AMotionWithoutAStampLeadsToTheNextScan) {
  for (const int version : {2, 3, 4, 5}) {
    const Content log = read(collection({motion(0.0, 0.5, version)}) +
                             frame({scan({.time_s = 100.1, .version = 6})}));
    EXPECT_EQ(log.skipped, 0) << version;
    ASSERT_EQ(log.odometry.size(), 1u) << version;
    EXPECT_EQ(log.odometry[0].stamp, log.scans.at(0).stamp);
    EXPECT_TRUE(std::holds_alternative<OdometryPose>(log.messages[0]));
  }
}

TEST(RawlogReader, EveryVersionOfItsClassesIsRead) {
  for (int version = 3; version <= 7; ++version) {
    EXPECT_EQ(read(scan({.time_s = 5.0, .version = version})).scans.size(), 1u) << version;
  }
  for (int version = 0; version <= 2; ++version) {
    EXPECT_EQ(read(odometry(5.0, 1.0, version)).odometry.size(), 1u) << version;
    const Content unstamped = read(scan({.version = version}));
    ASSERT_EQ(unstamped.scans.size(), 1u) << version;
    EXPECT_EQ(unstamped.warnings.size(), 1u) << "their stamps are made up";
  }
  EXPECT_EQ(read(collection({motion(5.0, 1.0, 7)})).odometry.size(), 1u);
  const std::string old_pose =
      old_object("CPose2D", 0, Bytes().add_float(1.5).add_float(0.5).add_float(0.25).text());
  const Content old = read(old_object(
      "CObservationOdometry", 0, Bytes().add_raw(old_pose).add_text("").add(ticks(7.0)).text()));
  ASSERT_EQ(old.odometry.size(), 1u);
  EXPECT_TRUE(pose_near(old.odometry[0].odom_T_robot, {1.5, 0.5, 0.25}, 1e-6, 1e-6));
}

TEST(RawlogReader, EstimatedMotionsAreReadAndTold) {
  const std::string gaussian =
      object("CPosePDFGaussian", 2,
             Bytes().add_raw(pose2(0.5, 0, 0)).add_raw(std::string(48, '\0')).text());
  Bytes bytes;
  bytes.add(std::int32_t{1}).add_raw(gaussian).add_raw(std::string(18, '\0')).add(ticks(5.0));
  const Content log = read(collection({object("CActionRobotMovement2D", 6, bytes.text())}));
  ASSERT_EQ(log.odometry.size(), 1u);
  EXPECT_TRUE(log.has_note("1 motions are estimates"));
}

TEST(RawlogReader, MarkedBeamsAtTheMaximumSawNothing) {
  const Content log = read(scan(
      {.time_s = 5.0, .ranges_m = {25.0, 23.0, 0.0, 3.0, 0.0, 25.0}, .valid = {0, 0, 0, 1, 1, 1}}));
  const auto& ranges_m = log.scans.at(0).ranges_m;
  EXPECT_TRUE(std::isinf(ranges_m[0]));
  EXPECT_TRUE(std::isnan(ranges_m[1]));
  EXPECT_TRUE(std::isnan(ranges_m[2]));
  EXPECT_FLOAT_EQ(ranges_m[3], 3.0F);
  EXPECT_TRUE(std::isnan(ranges_m[4]));
  EXPECT_TRUE(std::isinf(ranges_m[5]));
  // As a simulator writes them, with its noise on the maximum.
  const Content noisy =
      read(scan({.time_s = 5.0, .ranges_m = {24.0, 24.0, 24.0}, .valid = {0, 1, 0}}));
  EXPECT_TRUE(std::isinf(noisy.scans.at(0).ranges_m[0]));
  EXPECT_FLOAT_EQ(noisy.scans[0].ranges_m[1], 24.0F);
}

/// Where the first beam points to on the robot.
double first_beam(const LaserScan& scan) {
  return wrap_angle(scan.robot_T_lidar->yaw + scan.angle_min_rad);
}

TEST(RawlogReader, BeamsPointWhereTheyDidInSpace) {
  const LaserScan left_first = read(scan({.time_s = 5.0, .right_to_left = false})).scans.at(0);
  EXPECT_NEAR(first_beam(left_first), kPi / 2, 1e-6);
  EXPECT_LT(left_first.angle_increment_rad, 0.0);
  // Upside down and turned by 0.3: what was 90 deg to the right is to the left of where it looks.
  const Content upside_down = read(scan({.time_s = 5.0, .pose = pose3(0.1, 0.2, 0.3, kPi)}));
  EXPECT_NEAR(first_beam(upside_down.scans.at(0)), 0.3 + kPi / 2, 1e-6);
  EXPECT_LT(upside_down.scans[0].angle_increment_rad, 0.0);
  EXPECT_TRUE(upside_down.has_note("FLASER is mounted upside down"));
  EXPECT_TRUE(upside_down.warnings.empty());
}

TEST(RawlogReader, ATiltedLaserIsWarnedOf) {
  EXPECT_TRUE(read(scan({.time_s = 5.0, .pose = pitched_pose3(radians(1.5))})).warnings.empty());
  const Content tilted = read(scan({.time_s = 5.0, .pose = pitched_pose3(radians(12.0))}));
  ASSERT_EQ(tilted.warnings.size(), 1u);
  EXPECT_NE(tilted.warnings[0].find("tilted by 12.0 deg"), std::string::npos);
}

TEST(RawlogReader, LabelsTellLasersApartAndPlacesWhereThereAreNone) {
  const Content labelled =
      read(scan({.time_s = 5.0, .label = "REAR"}) + scan({.time_s = 5.1, .label = "FRONT"}) +
           scan({.time_s = 5.2, .label = "REAR"}));
  EXPECT_EQ(labelled.scans.at(0).lidar, 0);
  EXPECT_EQ(labelled.scans.at(1).lidar, 1);
  EXPECT_EQ(labelled.scans.at(2).lidar, 0);
  const Content placed = read(scan({.time_s = 5.0, .label = ""}) +
                              scan({.time_s = 5.1, .label = "", .pose = pose3(-0.2, 0.0, kPi)}));
  EXPECT_EQ(placed.scans.at(1).lidar, 1);
  const std::string bytes = scan({.time_s = 5.0, .label = "REAR", .pose = pose3(-0.2, 0, 3.0)});
  const RobotModel robot = read_rawlog(bytes, {})->robot({});
  EXPECT_EQ(robot.lidars.at(0).name, "REAR");
  EXPECT_TRUE(pose_near(robot.lidars[0].robot_T_lidar, {-0.2, 0.0, 3.0}, 1e-9, 1e-9));
}

TEST(RawlogReader, ObjectsOfOtherClassesArePassedOver) {
  const std::string picture =
      object("CObservationImage", 4, pose3(0, 0, 0) + std::string(5000, '\x88') + "CObservation");
  const std::string comment =
      object("mrpt::obs::CObservationComment", 0, Bytes().add_text("hello").add(ticks(1.0)).text());
  const Content log = read(comment + frame({picture, scan({.time_s = 5.0}), picture}) + comment +
                           odometry(5.2, 1.0) + picture);
  EXPECT_EQ(log.scans.size(), 1u);
  EXPECT_EQ(log.odometry.size(), 1u);
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.has_note("3 objects of CObservationImage are not read"));
  EXPECT_TRUE(log.has_note("2 objects of CObservationComment are not read"));
}

TEST(RawlogReader, DamageIsToldPassedAndWhatIsBehindItIsRead) {
  std::string broken = scan({.time_s = 5.1});
  broken.back() = '\x11';
  const std::string damages[] = {broken, std::string(300, '\x07'),
                                 scan({.time_s = 5.1}).substr(0, 90),
                                 scan({.time_s = 5.1, .ranges_m = {}, .valid = {}})};
  for (const std::string& damage : damages) {
    const Content log = read(scan({.time_s = 5.0}) + damage + scan({.time_s = 5.3}));
    EXPECT_EQ(log.scans.size(), 2u);
    ASSERT_GE(log.problems.size(), 1u);
    EXPECT_EQ(log.problems[0].location.byte_offset.value_or(0),
              static_cast<std::int64_t>(scan({.time_s = 5.0}).size()));
  }
  LogOptions strict;
  strict.strict = true;
  const std::string bytes = scan({.time_s = 5.0}) + broken;
  const auto log = read_rawlog(bytes, strict);
  EXPECT_THROW(
      {
        while (log->next()) {
        }
      },
      DataError);
}

TEST(RawlogReader, SizesThatCannotBeAreRefused) {
  std::string huge = scan_fields({.time_s = 5.0});
  const std::size_t count = 4 + 1 + 4 + pose3(0, 0, 0).size();
  const std::uint32_t beams = 4'000'000'000;
  std::memcpy(huge.data() + count, &beams, sizeof beams);
  const Content log = read(object("CObservation2DRangeScan", 7, huge) + scan({.time_s = 5.3}));
  EXPECT_EQ(log.scans.size(), 1u);
  ASSERT_EQ(log.problems.size(), 1u);
  EXPECT_NE(log.problems[0].reason.find("4000000000 beams"), std::string::npos);
  const std::string frames = object("CSensoryFrame", 2, Bytes().add_count(0xFFFFFFFF).text());
  std::string nested;
  for (int i = 0; i < 1000; ++i) nested += frames.substr(0, frames.size() - 1);
  EXPECT_EQ(read(nested + scan({.time_s = 5.0})).scans.size(), 1u);
}

TEST(RawlogReader, StampsAreMadeUpWhereThereAreNone) {
  std::string bytes;
  for (int i = 0; i < 8; ++i) {
    bytes += collection({motion(0.0, 0.5, 5)}) + frame({scan({.version = 6})});
  }
  const Content log = read(bytes);
  EXPECT_EQ(log.skipped, 0);
  ASSERT_EQ(log.scans.size(), 8u);
  EXPECT_NEAR((log.scans[7].stamp - log.scans[6].stamp).seconds(), 0.1, 1e-9);
  EXPECT_TRUE(log.in_time_order);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("10 scans a second (a usual rate"), std::string::npos);
  EXPECT_EQ(read(bytes, StampUse::kHeader).scans.size(), 0u) << "they have none";
}

TEST(RawlogReader, AFileWithNothingToMapSaysWhatThereIs) {
  const std::string picture = object("CObservationImage", 4, std::string(50, '\1'));
  try {
    (void)read(picture);
    FAIL() << "it was opened";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("there is CObservationImage"), std::string::npos);
  }
  EXPECT_THROW((void)read("hello"), DataError);
}

TEST(RawlogReader, IsRecognisedByItsContent) {
  const test::TempDir folder;
  for (const std::string& bytes : {scan({.time_s = 5.0}), collection({motion(5.0, 1.0)}),
                                   old_object("CSensoryFrame", 2, Bytes().add_count(0).text())}) {
    const LogInput log = look_at_log(folder.write("any_name", bytes));
    EXPECT_EQ(recognise_log(log).name, "rawlog");
  }
  EXPECT_FALSE(begins_as_rawlog("FLASER 180 1 2 3"));
  EXPECT_FALSE(begins_as_rawlog(""));
  EXPECT_FALSE(
      begins_as_rawlog("\x85"
                       "CJunk\x01 and more"));
}

/// Both forms of the same drive.
struct Recorded {
  std::string actions = test::recorded_data("rawlog/driving_in_office.rawlog");
  std::string observations = test::recorded_data("rawlog/driving_in_office_obs.rawlog");
  [[nodiscard]] bool is_there() const { return !actions.empty() && !observations.empty(); }
};

TEST(RawlogRecorded, BothFormsHoldTheSame) {
  const Recorded recorded;
  if (!recorded.is_there())
    GTEST_SKIP() << "rawlog is not among the recorded data; set LOOPSTONE_DATA";
  const LogContent actions = test::read_log(recorded.actions);
  const LogContent observations = test::read_log(recorded.observations);
  EXPECT_EQ(actions.skipped + observations.skipped, 0);
  ASSERT_EQ(actions.scans.size(), 1159u);
  ASSERT_EQ(observations.scans.size(), 1159u);
  ASSERT_EQ(actions.odometry.size(), 1161u);
  ASSERT_EQ(observations.odometry.size(), 1161u);
  EXPECT_TRUE(actions.in_time_order);
  std::size_t no_returns = 0;
  std::size_t bad = 0;
  for (std::size_t i = 0; i < 1159; ++i) {
    const LaserScan& a = actions.scans[i];
    const LaserScan& b = observations.scans[i];
    ASSERT_EQ(a.stamp, b.stamp);
    ASSERT_EQ(a.ranges_m.size(), 626u);
    ASSERT_EQ(std::memcmp(a.ranges_m.data(), b.ranges_m.data(), 626 * sizeof(float)), 0);
    for (const float range_m : a.ranges_m) {
      no_returns += std::isinf(range_m) ? 1 : 0;
      bad += std::isnan(range_m) ? 1 : 0;
    }
  }
  EXPECT_EQ(no_returns, 2121u) << "as many as are marked";
  EXPECT_EQ(bad, 0u);
  EXPECT_NEAR(actions.scans[0].stamp.seconds(), 56.479, 1e-9);
  EXPECT_TRUE(pose_near(actions.scans[0].robot_T_lidar.value(), {0.16, 0, 0}, 1e-9, 1e-9));
  EXPECT_NEAR(degrees(actions.scans[0].angle_min_rad), -110.0, 0.01);
  for (std::size_t i = 0; i < 1161; ++i) {
    EXPECT_EQ(actions.odometry[i].stamp, observations.odometry[i].stamp);
    EXPECT_TRUE(pose_near(actions.odometry[i].odom_T_robot, observations.odometry[i].odom_T_robot,
                          1e-6, 1e-6))
        << i;
  }
}

Trajectory path_of(const std::string& path) {
  const auto log = open_log(path);
  Mapper mapper(log->robot({}), {}, Threads{1});
  while (const auto message = log->next()) mapper.add(*message);
  return mapper.finish().trajectory;
}

TEST(RawlogRecorded, BothFormsGiveTheSameMap) {
  const Recorded recorded;
  if (!recorded.is_there())
    GTEST_SKIP() << "rawlog is not among the recorded data; set LOOPSTONE_DATA";
  const Trajectory actions = path_of(recorded.actions);
  const Trajectory observations = path_of(recorded.observations);
  ASSERT_EQ(actions.size(), 1159u);
  ASSERT_EQ(observations.size(), 1159u);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    ASSERT_TRUE(pose_near(actions.poses()[i].pose, observations.poses()[i].pose, 0.01, 0.005)) << i;
  }
}

}  // namespace
}  // namespace loopstone
