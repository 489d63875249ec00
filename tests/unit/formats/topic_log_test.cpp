// Recordings as logs: from topics to sensor messages.

#include "formats/topic_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/topic_choice.hpp"
#include "formats/topic_log_writer.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"
#include "support/simulated_log.hpp"
#include "support/temp_dir.hpp"
#include "topic_samples.hpp"

namespace loopstone {
namespace {

using test::mount;
using test::pose_near;
using test::read_told;
using test::TempDir;
using test::today;
using test::ToldLog;
using test::ToldTopics;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A robot that drives ahead with a laser 0.2 m before its middle.
ToldTopics robot(int scans = 60, const std::string& laser_topic = "/scan") {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < scans; ++i) {
    const double t = 0.1 * i;
    told.odometry("/odom", today(t), mount(0.05 * i, 0, 0, 0, 0, 0));
    told.scan(laser_topic, today(t + 0.01), "laser");
  }
  return told;
}

// Whole files.

struct Container {
  const char* name;
  std::unique_ptr<RecordingWriter> (*create)(const std::string&);
};
class EachContainer : public testing::TestWithParam<Container> {};

void expect_drive_comes_back(const Container& container, bool poses) {
  const TempDir folder;
  SimulationOptions options;
  options.duration_s = 5.0;
  options.start_s = test::kToday;
  options.laser.beams = 181;
  options.odometry_poses = poses;
  const auto drive = test::simulate_log("office", 3, options);
  const std::string path = folder / "drive";
  {
    const auto writer =
        create_topic_log({&log_format(container.name), path}, container.create(path), drive.robot);
    for (const SensorMessage& message : drive.messages) writer->write(message);
    writer->finish();
    EXPECT_THAT(writer->notes(), IsEmpty());
  }
  const auto log = test::read_log(path);
  EXPECT_EQ(log.skipped, 0);
  EXPECT_TRUE(log.in_time_order);
  ASSERT_EQ(log.messages.size(), drive.messages.size());
  const auto scans = drive.scans();
  ASSERT_EQ(log.scans.size(), scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(log.scans[i].stamp, scans[i].stamp);
    ASSERT_EQ(log.scans[i].ranges_m.size(), scans[i].ranges_m.size());
    for (std::size_t k = 0; k < scans[i].ranges_m.size(); ++k) {
      if (std::isnan(scans[i].ranges_m[k])) {
        EXPECT_TRUE(std::isnan(log.scans[i].ranges_m[k]));
      } else {
        EXPECT_EQ(log.scans[i].ranges_m[k], scans[i].ranges_m[k]);
      }
    }
    EXPECT_TRUE(
        pose_near(*log.scans[i].robot_T_lidar, mount_of(scans[i], drive.robot), 1e-9, 1e-9));
    EXPECT_NEAR(log.scans[i].time_increment_s, scans[i].time_increment_s, 1e-9);
  }
  std::size_t imu = 0;
  std::size_t ticks = 0;
  for (const SensorMessage& message : drive.messages) {
    if (const auto* sample = std::get_if<ImuSample>(&message)) {
      EXPECT_EQ(log.imu.at(imu).stamp, sample->stamp);
      EXPECT_LT((log.imu.at(imu).angular_velocity_rad_s - sample->angular_velocity_rad_s).norm(),
                1e-12);
      ++imu;
    }
    if (const auto* counts = std::get_if<WheelTicks>(&message)) {
      EXPECT_EQ(log.ticks.at(ticks++).counts, counts->counts);
    }
  }
  EXPECT_GT(poses ? log.odometry.size() : imu + ticks, 10u);
}

TEST_P(EachContainer, BringsASimulatedDriveBack) {
  for (const bool poses : {true, false}) expect_drive_comes_back(GetParam(), poses);
}

INSTANTIATE_TEST_SUITE_P(All, EachContainer,
                         testing::Values(Container{"mcap", create_mcap},
                                         Container{"bag", create_bag},
                                         Container{"rosbag2", create_rosbag2}),
                         [](const auto& given) { return given.param.name; });

TEST_P(EachContainer, StampsThatNoMessageHoldsAreRefused) {
  const TempDir folder;
  const auto writer = create_topic_log({&log_format(GetParam().name), folder / "log"},
                                       GetParam().create(folder / "log"), {});
  EXPECT_THROW(writer->write(OdometryPose{Stamp::from_seconds(-1e10), {}}), DataError);
}

// Mounts.

TEST(TopicLog, TwoLasersEachWithItsMount) {
  ToldTopics told = robot(50, "/front/scan");
  told.tf("/tf_static", today(0), "base_link", "rear", mount(-0.3, 0.1, 0.2, kPi, 0, kPi));
  for (int i = 0; i < 50; ++i) told.scan("/rear/scan", today(0.1 * i + 0.05), "/rear");
  const ToldLog log = read_told(told);
  ASSERT_EQ(log.content.scans.size(), 100u);
  EXPECT_EQ(log.content.scans[0].lidar, 0);
  EXPECT_TRUE(pose_near(*log.content.scans[0].robot_T_lidar, Pose2{0.2, 0, 0}, 1e-9, 1e-9));
  const LaserScan& rear = log.content.scans[1];
  EXPECT_EQ(rear.lidar, 1);
  EXPECT_TRUE(pose_near(*rear.robot_T_lidar, Pose2{-0.3, 0.1, kPi}, 1e-9, 1e-9));
  EXPECT_LT(rear.angle_increment_rad, 0.0) << "hangs upside down";
  ASSERT_EQ(log.robot.lidars.size(), 2u);
  EXPECT_EQ(log.robot.lidars[1].name, "/rear/scan");
  EXPECT_NEAR(log.robot.lidars[1].height_m, 0.2, 1e-12);
  EXPECT_THAT(log.choices, Contains(AllOf(HasSubstr("/rear/scan"), HasSubstr("upside down"))));
  EXPECT_EQ(log.topics.at("/rear/scan").role, TopicRole::kLaser);
  EXPECT_EQ(log.topics.at("/tf_static").role, TopicRole::kTransforms);
  EXPECT_EQ(log.topics.at("/odom").messages, 50);
  EXPECT_NEAR(log.topics.at("/odom").rate_hz, 10.0, 0.1);
}

TEST(TopicLog, OneTopicOfTwoLasers) {
  ToldTopics told = robot(40);
  told.tf("/tf_static", today(0), "base_link", "rear", mount(-0.3, 0, 0.3, 0, 0, kPi));
  for (int i = 0; i < 40; ++i) told.scan("/scan", today(0.1 * i + 0.05), "rear");
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.scans.size(), 40u) << "nobody looks backwards with the front laser's mount";
  for (const LaserScan& scan : log.content.scans) {
    EXPECT_TRUE(pose_near(*scan.robot_T_lidar, Pose2{0.2, 0, 0}, 1e-9, 1e-9));
  }
  EXPECT_EQ(log.content.skipped, 40);
  EXPECT_THAT(log.content.problems[0].reason, HasSubstr("a scan of the frame 'rear'"));
}

TEST(TopicLog, FixedFramesLateInTheFile) {
  for (const bool indexed : {true, false}) {
    ToldTopics told;
    for (int i = 0; i < 600; ++i) {
      told.odometry("/odom", today(0.1 * i), {});
      told.scan("/scan", today(0.1 * i), "laser");
    }
    told.tf("/tf_static", today(60), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
    told.is_indexed = indexed;
    const ToldLog log = read_told(told);
    ASSERT_EQ(log.content.scans.size(), 600u);
    EXPECT_EQ(log.content.scans[0].robot_T_lidar.has_value(), indexed);
    EXPECT_EQ(log.warnings.empty(), indexed);
  }
}

TEST(TopicLog, ScansLateInTheFile) {
  for (const bool indexed : {true, false}) {
    ToldTopics told;
    for (int i = 0; i < 6000; ++i) told.odometry("/odom", today(0.01 * i), {});
    told.tf("/tf_static", today(60), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
    for (int i = 0; i < 30; ++i) told.scan("/scan", today(60 + 0.1 * i), "laser");
    told.is_indexed = indexed;
    const ToldLog log = read_told(told);
    EXPECT_EQ(log.content.scans.size(), 30u) << indexed;
    EXPECT_THAT(log.warnings, IsEmpty());
  }
}

TEST(TopicLog, ATopicThatAppearsAfterWhatWasLookedAtIsListed) {
  ToldTopics told = robot(600);
  for (int i = 0; i < 20; ++i) told.imu(today(60 + 0.01 * i), {0, 0, 1}, {0, 0, 9.8});
  told.is_indexed = false;
  const ToldLog log = read_told(told, {.topics = {.count_all = true}});
  ASSERT_TRUE(log.topics.contains("/imu/data"));
  EXPECT_EQ(log.topics.at("/imu/data").messages, 20);
  EXPECT_THAT(log.topics.at("/imu/data").remark, HasSubstr("too late"));
}

TEST(TopicLog, ScansTakenWhileTheLaserWasTiltedAreLeftOutAndSaid) {
  ToldTopics told;
  double worst = 0.0;
  for (int i = 0; i < 1200; ++i) {
    const double t = 0.05 * i;
    // Stands for 20 s, then nods by 30 degrees.
    const double pitch = t < 20.0 ? 0.0 : radians(30) * std::sin(t - 20.0);
    told.odometry("/odom", today(t), {});
    told.tf("/tf", today(t), "base_link", "laser", mount(0.2, 0, 0.3, 0, pitch, 0));
    if (i % 2 == 0 && i < 1190) told.scan("/scan", today(t + 0.02), "laser");
    worst = std::max(worst, std::abs(pitch));
  }
  ASSERT_GT(worst, radians(29));
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.skipped, 0);
  for (const LaserScan& scan : log.content.scans) {
    const double t = (scan.stamp - today(0)).seconds();
    if (t > 20.0) {
      EXPECT_LT(std::abs(std::sin(t - 20.0)), 0.51) << t;
    }
  }
  const auto lost = 595 - log.content.scans.size();
  EXPECT_GT(lost, 200u);
  EXPECT_THAT(log.warnings,
              Contains(HasSubstr("/scan: " + std::to_string(lost) + " scans are not")));
}

// The inertial unit.

double yaw_rate_of(ToldTopics told, const Eigen::Vector3d& turning, const Eigen::Vector3d& force) {
  for (int i = 0; i < 200; ++i) told.imu(today(0.02 * i), turning, force);
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.imu.size(), 200u);
  return log.content.imu.empty() ? 0.0 : log.content.imu[0].angular_velocity_rad_s.z();
}

TEST(TopicLog, TheYawRateOfAnUpsideDownImuHasTheRightSign) {
  EXPECT_NEAR(yaw_rate_of(robot(), {0, 0, 0.5}, {0, 0, 9.8}), 0.5, 1e-9);
  EXPECT_NEAR(yaw_rate_of(robot(), {0, 0, -0.5}, {0.1, 0, -9.8}), 0.5, 0.01) << "by gravity";
  EXPECT_NEAR(yaw_rate_of(robot(), {0, 0.5, 0}, {0, 9.8, 0}), 0.5, 1e-9) << "on its side";
  ToldTopics told = robot();
  told.tf("/tf_static", today(0), "base_link", "imu_link", mount(0, 0, 0, kPi, 0, 0));
  EXPECT_NEAR(yaw_rate_of(told, {0, 0, -0.5}, {0, 0, -9.8}), 0.5, 1e-9) << "by tf";
  EXPECT_NEAR(yaw_rate_of(told, {0, 0, -0.5}, {0, 0, 0}), 0.5, 1e-9) << "a gyro alone, by tf";
  EXPECT_NEAR(yaw_rate_of(told, {0, 0, 0.5}, {0, 0, 9.8}), 0.5, 1e-9) << "gravity against tf";
}

TEST(TopicLog, AnImuThatDoesNotTurn) {
  ToldTopics told = robot();
  msg::Imu imu{.header = {today(1), "imu"}};
  imu.angular_velocity_covariance[0] = -1.0;
  told.add("/imu/data", today(1), imu);
  const ToldLog log = read_told(told, {.strict = true});
  EXPECT_THAT(log.content.imu, IsEmpty());
  EXPECT_EQ(log.topics.at("/imu/data").role, TopicRole::kNone);
  EXPECT_THAT(log.topics.at("/imu/data").remark, HasSubstr("does not measure turning"));
}

// Odometry.

TEST(TopicLog, OdometryOfAnotherFrameOnTheRobot) {
  ToldTopics told;
  const Pose3 footprint_T_link = mount(0.5, 0, 0.1, 0, 0, kPi / 2);
  told.tf("/tf_static", today(0), "base_footprint", "base_link", footprint_T_link);
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 20; ++i) {
    told.odometry("/odom", today(0.1 * i), mount(i, 0, 0, 0, 0, 0), "base_footprint");
    told.scan("/scan", today(0.1 * i + 0.01), "laser");
  }
  const ToldLog log = read_told(told, {.topics = {.base_frame = "base_link"}});
  ASSERT_EQ(log.content.odometry.size(), 20u);
  EXPECT_TRUE(pose_near(log.content.odometry[3].odom_T_robot, Pose2{3.5, 0, kPi / 2}, 1e-9, 1e-9));
  EXPECT_TRUE(pose_near(*log.content.scans[3].robot_T_lidar, Pose2{0.2, 0, 0}, 1e-9, 1e-9));
}

TEST(TopicLog, OdometryThatNamesTheFixedFrameAsItsChild) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 60; ++i) {
    const Pose3 pose = mount(0.1 * i, 0, 0, 0, 0, 0);
    told.tf("/tf", today(0.1 * i), "odom", "base_link", pose);
    told.odometry("/odom", today(0.1 * i), pose, "odom");
    told.scan("/scan", today(0.1 * i + 0.01), "laser");
  }
  const ToldLog log = read_told(told);
  ASSERT_EQ(log.content.odometry.size(), 60u);
  EXPECT_TRUE(pose_near(log.content.odometry[30].odom_T_robot, Pose2{3.0, 0, 0}, 1e-9, 1e-9));
  ASSERT_EQ(log.content.scans.size(), 60u);
  EXPECT_TRUE(pose_near(*log.content.scans[30].robot_T_lidar, Pose2{0.2, 0, 0}, 1e-9, 1e-9));
}

TEST(TopicLog, OdometryByTfEvenWhenItIsToldAgain) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 60; ++i) {
    const Stamp stamp = today(0.1 * i);
    told.tf("/tf", stamp, "/odom", "/base_link", mount(0.1 * i, 0, 0, 0, 0, 0));
    told.tf("/tf", stamp, "/odom", "/base_link", mount(0.1 * i, 0, 0, 0, 0, 0));
    told.tf("/tf", stamp, "map", "odom", mount(0.3 * i, 0, 0, 0, 0, 0));
    told.scan("/scan", stamp, "laser");
  }
  const ToldLog log = read_told(told, {.strict = true});
  ASSERT_EQ(log.content.odometry.size(), 60u);
  EXPECT_EQ(log.content.skipped, 0);
  EXPECT_TRUE(pose_near(log.content.odometry[10].odom_T_robot, Pose2{1, 0, 0}, 1e-9, 1e-9));
}

// Time.

TEST(TopicLog, StampsOfZeroGiveWayToTheRecorders) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 60; ++i) {
    told.odometry("/odom", Stamp{}, mount(0.05 * i, 0, 0, 0, 0, 0), "base_link", today(0.1 * i));
    told.scan("/scan", Stamp{}, "laser", 2.0, today(0.1 * i + 0.01));
  }
  const ToldLog log = read_told(told);
  ASSERT_EQ(log.content.scans.size(), 60u);
  EXPECT_EQ(log.content.scans[7].stamp, today(0.71));
  EXPECT_EQ(log.content.odometry[7].stamp, today(0.7));
  EXPECT_THAT(log.warnings, Contains(HasSubstr("/scan: its stamps are zero")));
}

TEST(TopicLog, StampsByTheOrderLoseNothing) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 600; ++i) {
    told.imu(today(0.01 * i), {0, 0, 0.1}, {0, 0, 9.8});
    if (i % 2 == 0) told.odometry("/odom", today(0.01 * i), mount(0.01 * i, 0, 0, 0, 0, 0));
    if (i % 10 == 5) told.scan("/scan", today(0.01 * i), "laser");
  }
  const ToldLog log = read_told(told, {.strict = true, .stamps = StampUse::kOrder});
  EXPECT_EQ(log.content.scans.size(), 60u);
  EXPECT_EQ(log.content.odometry.size(), 300u);
  EXPECT_EQ(log.content.imu.size(), 600u);
  EXPECT_TRUE(log.content.in_time_order);
  for (std::size_t i = 11; i < 60; ++i) {
    const Duration step = log.content.scans[i].stamp - log.content.scans[i - 1].stamp;
    EXPECT_NEAR(step.seconds(), 0.1, 1e-6);
    // The odometry lies about where it lay: five steps from scan to scan.
    const OdometryPose& pose = log.content.odometry[5 * i];
    const double late_s = (pose.stamp - log.content.scans[i].stamp).seconds();
    EXPECT_LT(std::abs(late_s), 0.101) << i;
  }
}

TEST(TopicLog, OrderWithoutAnyStampsButTf) {
  ToldTopics told;
  for (int i = 0; i < 100; ++i) {
    told.tf("/tf", Stamp{}, "odom", "base_link", mount(0.1 * i, 0, 0, 0, 0, 0));
    told.tf("/tf", Stamp{}, "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
    if (i % 2 == 0) told.scan("/scan", Stamp{}, "laser");
  }
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.scans.size(), 50u);
  EXPECT_EQ(log.content.odometry.size(), 100u);
  EXPECT_EQ(log.content.skipped, 0);
  EXPECT_THAT(log.warnings, Contains(HasSubstr("in their order")));
}

TEST(TopicLog, MessagesOutOfOrderArePutInOrder) {
  ToldTopics told = robot(60);
  for (std::size_t i = 11; i + 2 < told.messages.size(); i += 10) {
    std::swap(told.messages[i], told.messages[i + 2]);
  }
  const ToldLog log = read_told(told);
  EXPECT_TRUE(log.content.in_time_order);
  EXPECT_EQ(log.content.scans.size(), 60u);
  EXPECT_EQ(log.content.skipped, 0);
}

TEST(TopicLog, TheClockOfASimulationThatBeganAgain) {
  ToldTopics told = robot(400);
  for (int i = 0; i < 20; ++i) {
    told.scan("/scan", today(0.1 * i), "laser", 2.0, today(40 + 0.1 * i));
  }
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.scans.size(), 400u);
  EXPECT_EQ(log.content.skipped, 20);
  EXPECT_TRUE(log.content.in_time_order);
}

TEST(TopicLog, FramesThatAreDatedAheadAreNoOtherClock) {
  ToldTopics told;
  for (int i = 0; i < 60; ++i) {
    const Stamp now = today(0.1 * i);
    const Stamp ahead = now + Duration::from_seconds(1.0);
    told.tf("/tf", ahead, "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0), now);
    told.scan("/scan", now, "laser");
  }
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.scans.size(), 60u);
  EXPECT_THAT(log.warnings, IsEmpty());
}

TEST(TopicLog, AnotherComputersTfIsBroughtToTheLasersClock) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 60; ++i) {
    const Stamp now = today(0.1 * i);
    const Stamp other = now + Duration::from_seconds(7.0);
    told.tf("/tf", other, "odom", "base_link", mount(0.1 * i, 0, 0, 0, 0, 0), now);
    told.scan("/scan", now, "laser");
  }
  const ToldLog log = read_told(told);
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("tf of base_link: its clock is +7.00 s off")));
  ASSERT_EQ(log.content.odometry.size(), 60u);
  EXPECT_NEAR((log.content.odometry[10].stamp - today(1.0)).seconds(), 0.0, 1e-6);
}

TEST(TopicLog, FramesThatBeginToMoveUnderAnotherClockAreFollowed) {
  // Everything but the recorder's clock is in another century; a lift stands, then turns.
  ToldTopics told;
  for (int i = 0; i < 900; ++i) {
    const double t = 0.05 * i;
    const Stamp stuck = today(3e8);
    told.odometry("/odom", stuck, {}, "base_link", today(t));
    told.tf("/tf", stuck, "base_link", "laser",
            mount(0.2, 0, 0.3, 0, 0, t < 35 ? 0.0 : 0.1 * (t - 35)), today(t));
    told.scan("/scan", stuck, "laser", 2.0, today(t));
  }
  const ToldLog log = read_told(told);
  ASSERT_EQ(log.content.scans.size(), 900u);
  EXPECT_NEAR(log.content.scans[300].robot_T_lidar->yaw, 0.0, 1e-9);
  EXPECT_NEAR(log.content.scans[800].robot_T_lidar->yaw, 0.5, 0.01);
}

// What can't be read.

TEST(TopicLog, OneBrokenMessageIsNoReasonToGiveATopicUp) {
  for (const std::size_t broken : {std::size_t{2}, std::size_t{40}}) {
    ToldTopics told = robot(60);
    ASSERT_EQ(told.topics[told.messages[broken].topic].name, "/scan");
    told.messages[broken].bytes.resize(30);
    const ToldLog log = read_told(told);
    EXPECT_EQ(log.content.scans.size(), 59u);
    EXPECT_EQ(log.content.skipped, 1);
    EXPECT_EQ(log.topics.at("/scan").role, TopicRole::kLaser);
    EXPECT_EQ(log.topics.at("/scan").remark, "");
    EXPECT_THROW((void)read_told(told, {.strict = true}), DataError);
  }
}

TEST(TopicLog, TopicsInOtherEncodingsAreListedWithTheReason) {
  ToldTopics told = robot(60);
  told.scan("/json", today(7), "laser");
  told.topics.back().unreadable = "encoded as json";
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.scans.size(), 60u);
  EXPECT_EQ(log.topics.at("/json").remark, "encoded as json");
  EXPECT_EQ(log.topics.at("/json").role, TopicRole::kNone);
  EXPECT_THROW((void)read_told(told, {.topics = {.named = {{TopicRole::kLaser, "/json"}}}}),
               UsageError);
}

TEST(TopicLog, ADefinitionOfItsOwnIsUnderstood) {
  ToldTopics told = robot(30);
  const std::size_t topic = told.number_of<msg::LaserScan>("/scan");
  const std::string ours = MessageType<msg::LaserScan>::ros2_definition();
  const std::string field = "float32[] ranges";
  ASSERT_NE(ours.find(field), std::string::npos) << ours;
  std::string wide = ours;
  wide.replace(wide.find(field), field.size(), "float64[] ranges");
  told.topics[topic].definition = {DefinitionLanguage::kRos2Msg, wide};
  for (auto& message : told.messages) {
    if (message.topic != topic) continue;
    msg::LaserScan scan;
    MessageDecoder<msg::LaserScan>(WireFormat::kCdr).decode(message.bytes, scan);
    // The empty intensities at the end are a length of zero; the ranges are made twice as long.
    const std::size_t ranges_bytes = 4 * scan.ranges.size();
    std::string& bytes = message.bytes;
    std::string head = bytes.substr(0, bytes.size() - 4 - ranges_bytes);
    while ((head.size() - 4) % 8 != 0) head += '\0';
    for (const float range : scan.ranges) {
      const auto value = static_cast<double>(range);
      head.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    bytes = head + std::string(4, '\0');
  }
  const ToldLog log = read_told(told);
  ASSERT_EQ(log.content.scans.size(), 30u);
  EXPECT_EQ(log.content.scans[3].ranges_m.size(), 101u);
  EXPECT_EQ(log.content.scans[3].ranges_m[50], 2.0F);
}

TEST(TopicLog, WithoutFramesTheRobotFileTellsTheMount) {
  ToldTopics told;
  for (int i = 0; i < 30; ++i) told.scan("/scan", today(0.1 * i), "");
  const ToldLog log = read_told(told);
  EXPECT_FALSE(log.content.scans[0].robot_T_lidar);
  EXPECT_THAT(log.warnings, Contains(HasSubstr("--robot FILE")));
  EXPECT_THAT(log.choices, Contains(HasSubstr("odometry none")));
  ToldTopics cloud;
  msg::PointCloud2 points{.header = {today(0), "velodyne"}, .height = 1, .point_step = 12};
  points.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}};
  for (int i = 0; i < 5; ++i) {
    points.header.stamp = today(0.1 * i);
    cloud.add("/points", points.header.stamp, points);
  }
  const ToldLog sliced = read_told(cloud);
  ASSERT_EQ(sliced.content.scans.size(), 5u);
  EXPECT_FALSE(sliced.content.scans[0].robot_T_lidar) << "else no file could tell the mount";
}

// Truth.

TEST(TopicLogTruth, OfATopicAndOfAFrame) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  for (int i = 0; i < 100; ++i) {
    const Stamp stamp = today(0.1 * i);
    told.tf("/tf", stamp, "odom", "base_link", mount(0.1 * i, 0, 0, 0, 0, 0));
    if (i % 5 == 0) told.tf("/tf", stamp, "world", "odom", mount(0, 1.0 + 0.01 * i, 0, 0, 0, 0));
    told.scan("/scan", stamp, "laser");
    msg::PoseStamped pose{.header = {stamp + Duration::from_seconds(500), "world"}};
    pose.pose.position = {0.1 * i, 1.0, 0.0};
    told.add("/mocap", stamp, pose);
  }
  const auto truth = [&](const std::string& topic) {
    return read_topic_truth("told", topic, test::opener_of(told), {});
  };
  const Trajectory mocap = truth("mocap");
  EXPECT_EQ(mocap.size(), 100u);
  ASSERT_TRUE(mocap.at(today(3.0))) << "its clock is 500 s off the laser's";
  EXPECT_TRUE(pose_near(*mocap.at(today(3.0)), Pose2{3.0, 1.0, 0}, 1e-3, 1e-9));
  const Trajectory frame = truth("tf:/world");
  ASSERT_TRUE(frame.at(today(3.2)));
  EXPECT_TRUE(pose_near(*frame.at(today(3.2)), Pose2{3.2, 1.32, 0}, 1e-6, 1e-9));
  for (const char* const none : {"/scan", "/nothing", "tf:nowhere", "tf:"}) {
    try {
      (void)truth(none);
      ADD_FAILURE() << none;
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("/mocap"), HasSubstr("tf:FRAME"))) << none;
    }
  }
}

}  // namespace
}  // namespace loopstone
