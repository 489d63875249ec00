// Wheels of recordings by the messages of many robots.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <utility>

#include "formats/message_scan.hpp"
#include "formats/wheel_plan.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/simulated_log.hpp"
#include "wheel_samples.hpp"

namespace loopstone {
namespace {

using test::add_raw;
using test::CdrMessage;
using test::mount;
using test::of_fields;
using test::put_in_order;
using test::read_told;
using test::Rolled;
using test::rolled_m;
using test::RollingRobot;
using test::scans_and_frames;
using test::today;
using test::ToldLog;
using test::ToldTopics;
using test::with_header;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr double kTurn = 2.0 * kPi;

/// How a driver tells joints.
struct JointTeller {
  std::vector<std::string> names{"wheel_left_joint", "wheel_right_joint"};
  bool positions = true;
  bool speeds = false;
  bool wraps = false;
  bool other_joints = false;
  bool one_by_one = false;
  bool swaps = false;  ///< the order from message to message
};

void tell_joints(ToldTopics& told, const JointTeller& teller, const RollingRobot& robot = {},
                 const std::string& topic = "/joint_states") {
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    const double moving = t > 1.0 ? 1.0 : t < 1.0 ? 0.0 : 0.5;
    const double radius_m = RollingRobot::kRadiusM;
    const std::vector<double> angles{robot.left_m(t) / radius_m, robot.right_m(t) / radius_m};
    const std::vector<double> speeds{moving * robot.left_m_s / radius_m,
                                     moving * robot.right_m_s / radius_m};
    std::vector<std::size_t> order{0, 1};
    if (teller.swaps && i % 2 == 1) order = {1, 0};
    msg::JointState message{.header = {today(t), ""}};
    const auto send = [&] {
      told.add(topic, message.header.stamp, message);
      message.name.clear();
      message.position.clear();
      message.velocity.clear();
    };
    for (const std::size_t k : order) {
      if (teller.other_joints) {
        message.name.emplace_back(k == 0 ? "caster_left_wheel_joint" : "lidar_spin_joint");
        message.position.push_back(100.0 * t);
        if (teller.speeds) message.velocity.push_back(100.0);
      }
      message.name.push_back(teller.names[k]);
      const double angle = 7.0 + angles[k];
      if (teller.positions) message.position.push_back(teller.wraps ? wrap_angle(angle) : angle);
      if (teller.speeds) message.velocity.push_back(speeds[k]);
      if (teller.one_by_one) send();
    }
    if (!teller.one_by_one) send();
  }
  put_in_order(told);
}

void expect_rolled(const ToldLog& log, const RollingRobot& robot = {}, double tolerance_m = 1e-3) {
  ASSERT_GT(log.content.ticks.size(), 190u);
  EXPECT_TRUE(log.content.in_time_order);
  EXPECT_NEAR(log.robot.wheels.track_width_m, RollingRobot::kTrackM, 1e-9);
  EXPECT_FALSE(log.robot.wheels.counts_are_cumulative);
  const Rolled rolled = rolled_m(log);
  EXPECT_NEAR(rolled.left, robot.left_m(RollingRobot::last_s()), tolerance_m);
  EXPECT_NEAR(rolled.right, robot.right_m(RollingRobot::last_s()), tolerance_m);
}

TEST(WheelJoints, EverySpellingOfADriver) {
  std::vector<JointTeller> tellers(8);
  tellers[1].wraps = true;
  tellers[2].positions = false;
  tellers[2].speeds = true;
  tellers[3].other_joints = true;
  tellers[3].speeds = true;
  tellers[4].one_by_one = true;
  tellers[5].swaps = true;
  tellers[6].names = {"robot1/drivewhl_l_joint", "robot1/drivewhl_r_joint"};
  tellers[7] = {.speeds = true, .wraps = true, .other_joints = true, .swaps = true};
  for (std::size_t i = 0; i < tellers.size(); ++i) {
    SCOPED_TRACE(i);
    ToldTopics told = scans_and_frames(true);
    tell_joints(told, tellers[i]);
    const ToldLog log = read_told(told);
    expect_rolled(log);
    EXPECT_EQ(log.content.skipped, 0);
    EXPECT_EQ(log.topics.at("/joint_states").role, TopicRole::kWheels);
    EXPECT_THAT(log.choices, Contains(AllOf(HasSubstr("wheels   /joint_states"),
                                            HasSubstr("radius 0.1 m (tf), track 0.5 m (tf)"))));
    EXPECT_THAT(log.warnings, IsEmpty());
    EXPECT_THAT(log.content.notes, Not(Contains(HasSubstr("out of the order"))));
  }
}

TEST(WheelJoints, PositionsThatStandStillGiveWayToSpeeds) {
  ToldTopics told = scans_and_frames(true);
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    msg::JointState message{.header = {today(RollingRobot::time_s(i)), ""}};
    message.name = {"left_wheel", "right_wheel"};
    message.position = {0.0, 0.0};
    message.velocity = {i < 20 ? 0.0 : 3.0, i < 20 ? 0.0 : 5.0};
    told.add("/joint_states", message.header.stamp, message);
  }
  put_in_order(told);
  const ToldLog log = read_told(told);
  expect_rolled(log, {}, 0.02);
  EXPECT_THAT(log.content.notes, Contains(HasSubstr("their speeds count")));
}

TEST(WheelJoints, TwoTopicsOfOneWheelEach) {
  ToldTopics told = scans_and_frames(true);
  const RollingRobot robot;
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    for (const bool is_left : {true, false}) {
      const double t = RollingRobot::time_s(i) + (is_left ? 0.0 : 0.02);
      msg::JointState message{.header = {today(t), ""}};
      message.name = {is_left ? "left_wheel" : "right_wheel"};
      message.position = {(is_left ? robot.left_m(t) : robot.right_m(t)) / RollingRobot::kRadiusM};
      told.add(is_left ? "/left/joint" : "/right/joint", message.header.stamp, message);
    }
  }
  put_in_order(told);
  const ToldLog log = read_told(told);
  expect_rolled(log);
  EXPECT_THAT(log.choices, Contains(HasSubstr("/left/joint and /right/joint")));
  EXPECT_THAT(log.content.notes, Not(Contains(HasSubstr("out of the order"))));
}

TEST(WheelJoints, TheRobotFileBeatsTf) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  const ToldLog log = read_told(told, {.topics = {.wheels = {.radius_m = 0.2}}});
  EXPECT_NEAR(log.robot.wheels.metres_per_count, 0.2 * kRadiansPerCount, 1e-15);
  EXPECT_EQ(log.robot.wheels.radius_m, 0.2);
  EXPECT_THAT(log.choices, Contains(HasSubstr("radius 0.2 m (--robot), track 0.5 m (tf)")));
}

TEST(WheelJoints, WhatNobodyTellsIsAskedForAndNothingIsGuessed) {
  ToldTopics told = scans_and_frames(false);
  tell_joints(told, {});
  const ToldLog log = read_told(told);
  EXPECT_THAT(log.content.ticks, IsEmpty());
  EXPECT_THAT(log.warnings, Contains(AllOf(HasSubstr("/joint_states: angles of wheels"),
                                           HasSubstr("give them in [wheels] of --robot FILE"),
                                           HasSubstr("radius_m and track_width_m"))));
  EXPECT_THAT(log.topics.at("/joint_states").remark, HasSubstr("radius_m"));
  EXPECT_EQ(log.robot.wheels.metres_per_count, WheelModel{}.metres_per_count);

  ToldTopics floating = scans_and_frames(true, false);  // no footprint: no radius
  tell_joints(floating, {});
  EXPECT_THAT(read_told(floating).warnings,
              Contains(AllOf(HasSubstr("without radius_m"), Not(HasSubstr("track_width_m")))));
  expect_rolled(read_told(floating, {.topics = {.wheels = {.radius_m = RollingRobot::kRadiusM}}}));
}

TEST(WheelJoints, OdometryComesFirstUnlessTheWheelsAreNamed) {
  ToldTopics told = scans_and_frames(true);
  for (int i = 0; i < 200; ++i) {
    told.odometry("/odom", today(0.05 * i), mount(0.01 * i, 0, 0, 0, 0, 0), "base_footprint");
  }
  tell_joints(told, {});
  const ToldLog log = read_told(told);
  EXPECT_THAT(log.content.ticks, IsEmpty());
  EXPECT_THAT(log.content.odometry, SizeIs(200));
  EXPECT_THAT(log.topics.at("/joint_states").remark, HasSubstr("no odometry"));
  EXPECT_EQ(log.robot.wheels.metres_per_count, WheelModel{}.metres_per_count);

  const ToldLog named =
      read_told(told, {.topics = {.named = {{TopicRole::kWheels, "joint_states"}}}});
  expect_rolled(named);
  EXPECT_THAT(named.content.odometry, IsEmpty());
  EXPECT_THAT(named.choices, Contains(HasSubstr("odometry none")));
  EXPECT_THAT(named.topics.at("/odom").remark, HasSubstr("wheels that were named"));

  const ToldLog both = read_told(told, {.topics = {.named = {{TopicRole::kWheels, "/joint_states"},
                                                             {TopicRole::kOdometry, "/odom"}}}});
  EXPECT_THAT(both.content.odometry, SizeIs(200));
  EXPECT_THAT(both.content.ticks, Not(IsEmpty()));
  const ToldLog none = read_told(told, {.topics = {.named = {{TopicRole::kOdometry, ""}}}});
  EXPECT_THAT(none.content.ticks, IsEmpty());
}

TEST(WheelJoints, OurOwnTicksComeFirst) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  for (int i = 0; i < 100; ++i) {
    told.add("/wheel_ticks", today(0.1 * i), msg::WheelTicks{.header = {today(0.1 * i), ""}});
  }
  put_in_order(told);
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.topics.at("/wheel_ticks").role, TopicRole::kWheels);
  EXPECT_EQ(log.topics.at("/joint_states").role, TopicRole::kNone);
  EXPECT_THAT(log.content.ticks, SizeIs(100));
  EXPECT_EQ(log.robot.wheels.metres_per_count, WheelModel{}.metres_per_count);
}

TEST(WheelJoints, JointsWithoutWheels) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {.names = {"shoulder_left_joint", "caster_right_wheel"}});
  const ToldLog log = read_told(told);
  EXPECT_THAT(log.content.ticks, IsEmpty());
  EXPECT_THAT(log.warnings, IsEmpty());
  EXPECT_EQ(log.topics.at("/joint_states").remark, "names no wheels of both sides");
  EXPECT_THROW(
      (void)read_told(told, {.topics = {.named = {{TopicRole::kWheels, "/joint_states"}}}}),
      UsageError);
}

TEST(WheelJoints, WhatIsWantedOfTheWheelsIsNotWhatTheyDid) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {}, {.left_m_s = 1.0, .right_m_s = 1.0}, "/cmd_joints");
  tell_joints(told, {});
  const ToldLog log = read_told(told);
  expect_rolled(log);
  EXPECT_EQ(log.topics.at("/cmd_joints").role, TopicRole::kNone);
}

TEST(WheelJoints, FrontWheelsThatAreSteeredDoNotCount) {
  ToldTopics told = scans_and_frames(true);
  const RollingRobot robot;
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    msg::JointState message{.header = {today(t), ""}};
    message.name = {"front_left_steering_joint", "front_left_wheel", "front_right_wheel",
                    "rear_left_wheel", "rear_right_wheel"};
    message.position = {0.3, 50.0 * t, 60.0 * t, robot.left_m(t) / RollingRobot::kRadiusM,
                        robot.right_m(t) / RollingRobot::kRadiusM};
    told.add("/joint_states", message.header.stamp, message);
  }
  put_in_order(told);
  expect_rolled(read_told(told));
}

TEST(WheelJoints, FourWheelsThatSkidNeedAWiderTrack) {
  ToldTopics told = scans_and_frames(true);
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    msg::JointState message{.header = {today(RollingRobot::time_s(i)), ""}};
    message.name = {"front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"};
    message.position.assign(4, 0.1 * i);
    told.add("/joint_states", message.header.stamp, message);
  }
  put_in_order(told);
  EXPECT_THAT(read_told(told).warnings, Contains(HasSubstr("slip sideways")));
  EXPECT_THAT(read_told(told, {.topics = {.wheels = {.track_width_m = 0.8}}}).warnings, IsEmpty());
}

TEST(WheelJoints, WithoutStampsThereIsNoTellingHowFast) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  const ToldLog log = read_told(told, {.stamps = StampUse::kOrder});
  EXPECT_THAT(log.content.ticks, IsEmpty());
  EXPECT_THAT(log.warnings, Contains(HasSubstr("wheels need stamps")));
  EXPECT_THAT(log.choices, Not(Contains(HasSubstr("wheels   "))));
  const ToldLog recorded = read_told(told, {.stamps = StampUse::kRecord});
  expect_rolled(recorded);
}

TEST(WheelJoints, WithoutAnIndexTheyAreFoundAsWell) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  told.is_indexed = false;
  expect_rolled(read_told(told));
}

// Counts.

/// Wheels of 1000 counts a metre.
constexpr double kCountsAMetre = 1000.0;
const StatedWheels kStated{.metres_per_count = 1.0 / kCountsAMetre,
                           .track_width_m = RollingRobot::kTrackM};

struct Counter {
  const char* name;
  const char* type;
  MessageDefinition definition;
  std::function<CdrMessage(Stamp, double, double)> message;  ///< of counts left and right
};

template <typename T>
T wrapped(double counts) {
  return static_cast<T>(static_cast<std::int64_t>(std::floor(counts)));
}

std::vector<Counter> counters() {
  std::vector<Counter> all;
  all.push_back({"/wheel_ticks", "irobot_create_msgs/WheelTicks",
                 with_header("int32 ticks_left\nint32 ticks_right\n"),
                 [](Stamp stamp, double left, double right) {
                   return CdrMessage()
                       .header(stamp)
                       .put(wrapped<std::int32_t>(left))
                       .put(wrapped<std::int32_t>(right));
                 }});
  all.push_back(all.back());
  all.back().definition = {};  // ROS 2 before Iron
  all.push_back({"/core", "kobuki_msgs/SensorState",
                 with_header("uint16 time_stamp\nuint8 bumper\nuint8 wheel_drop\n"
                             "uint16 left_encoder\nuint16 right_encoder\nint8 left_pwm\n"
                             "int8 right_pwm\nuint8[] current\n"),
                 [](Stamp stamp, double left, double right) {
                   CdrMessage message;
                   message.header(stamp).put(std::uint16_t{7}).put(std::uint8_t{1});
                   message.put(std::uint8_t{0}).put(wrapped<std::uint16_t>(left + 65'000.0));
                   message.put(wrapped<std::uint16_t>(right + 65'000.0));
                   return message.put(std::int8_t{50}).put(std::int8_t{-50}).put(0U);
                 }});
  all.push_back({"/encoders",
                 "mir_msgs/StampedEncoders",
                 {DefinitionLanguage::kRos2Msg,
                  "std_msgs/Header header\nmir_msgs/Encoders encoders\n" + std::string(80, '=') +
                      "\nMSG: mir_msgs/Encoders\nfloat32 time_delta\nint32 left_wheel\n"
                      "int32 right_wheel\n" +
                      std::string(80, '=') +
                      "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"},
                 [](Stamp stamp, double left, double right) {
                   return CdrMessage()
                       .header(stamp)
                       .put(0.05F)
                       .put(wrapped<std::int32_t>(left))
                       .put(wrapped<std::int32_t>(right));
                 }});
  return all;
}

TEST(WheelCounts, OfOneMessageForBothWheels) {
  for (const Counter& counter : counters()) {
    SCOPED_TRACE(counter.type);
    ToldTopics told = scans_and_frames(false);
    const RollingRobot robot{.left_m_s = 0.9, .right_m_s = -1.1};
    for (int i = 0; i < RollingRobot::kReadings; ++i) {
      const double t = RollingRobot::time_s(i);
      add_raw(told, counter.name, counter.type, counter.definition, today(t),
              counter.message(today(t), kCountsAMetre * robot.left_m(t),
                              kCountsAMetre * robot.right_m(t)));
    }
    put_in_order(told);
    const ToldLog log = read_told(told, {.topics = {.wheels = kStated}});
    expect_rolled(log, robot, 3e-3);
    EXPECT_THAT(log.choices, Contains(AllOf(HasSubstr("wheels   "), HasSubstr("(--robot)"))));
    const ToldLog unknown = read_told(told);
    EXPECT_THAT(unknown.content.ticks, IsEmpty()) << "the default robot is another one";
    EXPECT_THAT(unknown.warnings,
                Contains(AllOf(HasSubstr(counter.name), HasSubstr("counts of wheels"),
                               HasSubstr("metres_per_count and track_width_m"))));
  }
}

TEST(WheelCounts, OfATopicForEachWheel) {
  const RollingRobot robot;
  for (const bool has_definition : {true, false}) {
    ToldTopics told = scans_and_frames(false);
    const MessageDefinition definition =
        has_definition ? of_fields("int16 data\n") : MessageDefinition{};
    for (int i = 0; i < RollingRobot::kReadings; ++i) {
      const double t = RollingRobot::time_s(i);
      add_raw(told, "/lwheel", "std_msgs/Int16", definition, today(t),
              CdrMessage().put(wrapped<std::int16_t>(10'000.0 * robot.left_m(t) + 32'000.0)));
      add_raw(told, "/rwheel", "std_msgs/Int16", definition, today(t + 0.01),
              CdrMessage().put(wrapped<std::int16_t>(10'000.0 * robot.right_m(t + 0.01))));
      add_raw(told, "/battery_left", "std_msgs/Int16", definition, today(t),
              CdrMessage().put(std::int16_t{5}));
    }
    put_in_order(told);
    StatedWheels stated = kStated;
    stated.metres_per_count = 1e-4;
    const ToldLog log = read_told(told, {.topics = {.wheels = stated}});
    expect_rolled(log, robot, 3e-3);
    EXPECT_EQ(log.topics.at("/lwheel").role, TopicRole::kWheels);
    EXPECT_EQ(log.topics.at("/rwheel").role, TopicRole::kWheels);
    EXPECT_EQ(log.topics.at("/battery_left").role, TopicRole::kNone);
  }
}

TEST(WheelCounts, EncodersThatSayHowManyCountsMakeATurnAreAngles) {
  const RollingRobot robot;
  ToldTopics told = scans_and_frames(true);
  const MessageDefinition definition = with_header("uint32 data\nuint16 resolution\nuint8 type\n");
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    for (const bool is_left : {true, false}) {
      const double rolled_m = is_left ? robot.left_m(t) : robot.right_m(t);
      const double counts = 1350.0 * rolled_m / RollingRobot::kRadiusM / kTurn;
      CdrMessage message;
      message.header(today(t)).put(wrapped<std::uint32_t>(counts)).put(std::uint16_t{1350});
      add_raw(
          told,
          is_left ? "/duck/left_wheel_encoder_node/tick" : "/duck/right_wheel_encoder_node/tick",
          "duckietown_msgs/WheelEncoderStamped", definition, today(t),
          message.put(std::uint8_t{1}));
    }
  }
  put_in_order(told);
  const ToldLog log = read_told(told);
  expect_rolled(log, robot, 2e-3);
  EXPECT_THAT(log.choices, Contains(HasSubstr("radius 0.1 m (tf)")));
}

TEST(WheelCounts, DrivesThatTellTheirTravelInRadians) {
  const RollingRobot robot;
  ToldTopics told = scans_and_frames(true);
  MessageDefinition definition = with_header("jackal_msgs/DriveFeedback[2] drivers\n");
  definition.text += std::string(80, '=') +
                     "\nMSG: jackal_msgs/DriveFeedback\nfloat32 current\n"
                     "float32 measured_velocity\nfloat32 measured_travel\nbool driver_fault\n";
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    CdrMessage message;
    message.header(today(t));
    for (const double rolled_m : {robot.left_m(t), robot.right_m(t)}) {
      message.put(1.0F).put(0.0F).put(static_cast<float>(rolled_m / RollingRobot::kRadiusM));
      message.put(std::uint8_t{0});
    }
    add_raw(told, "/feedback", "jackal_msgs/Feedback", definition, today(t), message);
  }
  put_in_order(told);
  expect_rolled(read_told(told), robot);
}

TEST(WheelCounts, SpeedsOfWheelsAreSummedUp) {
  ToldTopics told = scans_and_frames(true);
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    const float moving = t > 1.0 ? 1.0F : t < 1.0 ? 0.0F : 0.5F;
    add_raw(told, "/wheel_vels", "irobot_create_msgs/WheelVels", {}, today(t),
            CdrMessage().header(today(t)).put(3.0F * moving).put(5.0F * moving));
  }
  put_in_order(told);
  expect_rolled(read_told(told));
}

TEST(WheelCounts, CountsSinceTheLastReadingWhereTheRobotFileSaysSo) {
  ToldTopics told = scans_and_frames(false);
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    add_raw(told, "/wheel_ticks", "irobot_create_msgs/WheelTicks",
            with_header("int32 ticks_left\nint32 ticks_right\n"), today(t),
            CdrMessage().header(today(t)).put(i > 20 ? 15 : 0).put(i > 20 ? 25 : 0));
  }
  put_in_order(told);
  StatedWheels stated = kStated;
  stated.counts_are_cumulative = false;
  expect_rolled(read_told(told, {.topics = {.wheels = stated}}), {}, 0.03);
}

TEST(WheelCounts, JointsComeFirst) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  for (int i = 0; i < RollingRobot::kReadings; ++i) {
    const double t = RollingRobot::time_s(i);
    add_raw(told, "/wheel_ticks", "irobot_create_msgs/WheelTicks", {}, today(t),
            CdrMessage().header(today(t)).put(i).put(i));
  }
  put_in_order(told);
  const ToldLog log = read_told(told, {.topics = {.wheels = kStated}});
  EXPECT_EQ(log.topics.at("/joint_states").role, TopicRole::kWheels);
  EXPECT_EQ(log.topics.at("/wheel_ticks").role, TopicRole::kNone);
  EXPECT_THAT(log.topics.at("/wheel_ticks").remark, HasSubstr("another one"));
  const ToldLog named = read_told(
      told, {.topics = {.named = {{TopicRole::kWheels, "/wheel_ticks"}}, .wheels = kStated}});
  EXPECT_EQ(named.topics.at("/wheel_ticks").role, TopicRole::kWheels);
}

TEST(WheelCounts, DamagedMessagesAreSkippedAndCounted) {
  ToldTopics told = scans_and_frames(true);
  tell_joints(told, {});
  const std::size_t topic = told.number_of<msg::JointState>("/joint_states");
  std::size_t spoiled = 0;
  for (auto& message : told.messages) {
    if (message.topic != topic || ++spoiled % 50 != 0) continue;
    message.bytes.resize(message.bytes.size() / 2);
  }
  const ToldLog log = read_told(told);
  EXPECT_EQ(log.content.skipped, 4);
  EXPECT_EQ(log.content.ticks.size(), 196u);
}

// Against the truth.

/// The angles that the joints of a simulated robot would have had, by its wheel counts.
ToldTopics joints_of(const test::SimulatedLog& drive, double radius_m) {
  ToldTopics told;
  const double half_track_m = 0.5 * drive.robot.wheels.track_width_m;
  told.tf("/tf_static", today(0), "base_footprint", "laser", mount(0.14, 0, 0.5, 0, 0, 0));
  for (const bool is_left : {true, false}) {
    const double y_m = is_left ? half_track_m : -half_track_m;
    told.tf("/tf_static", today(0), "base_footprint", is_left ? "left_wheel" : "right_wheel",
            mount(0, y_m, radius_m, 0, 0, 0));
  }
  std::array<std::int64_t, 4> totals{};
  for (const SensorMessage& message : drive.messages) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      told.add("/scan", scan->stamp, to_message(*scan, "laser"));
    } else if (const auto* imu = std::get_if<ImuSample>(&message)) {
      told.imu(imu->stamp, imu->angular_velocity_rad_s, imu->linear_acceleration_m_s2,
               "base_footprint");
    } else if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
      msg::JointState joints{.header = {ticks->stamp, ""}};
      joints.name = {"front_right_wheel", "front_left_wheel", "rear_right_wheel",
                     "rear_left_wheel"};
      for (std::size_t i = 0; i < 4; ++i) {
        totals[i] += ticks->counts[i];
        joints.position.push_back(static_cast<double>(totals[i]) *
                                  drive.robot.wheels.metres_per_count / radius_m);
      }
      told.add("/joint_states", ticks->stamp, joints);
    }
  }
  return told;
}

/// How far apart two trajectories with the same stamps are at most: metres and radians.
std::pair<double, double> farthest_apart(const Trajectory& a, const Trajectory& b) {
  std::pair<double, double> farthest{0.0, 0.0};
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    EXPECT_EQ(a.poses()[i].stamp, b.poses()[i].stamp);
    const Pose2 off = a.poses()[i].pose.inverse() * b.poses()[i].pose;
    farthest.first = std::max(farthest.first, std::hypot(off.x, off.y));
    farthest.second = std::max(farthest.second, std::abs(off.yaw));
  }
  return farthest;
}

Trajectory mapped(const std::vector<SensorMessage>& messages, const RobotModel& robot) {
  Mapper mapper(robot, {}, Threads{1});
  for (const SensorMessage& message : messages) mapper.add(message);
  return mapper.finish().trajectory;
}

TEST(WheelJoints, ASimulatedDriveIsMappedAsByItsOwnCounts) {
  SimulationOptions options;
  options.duration_s = 15.0;
  options.start_s = test::kToday;
  options.laser.beams = 181;
  const auto drive = test::simulate_log("office", 3, options);
  const ToldTopics told = joints_of(drive, 0.11);
  const ToldLog log = read_told(told);
  const Trajectory by_joints = mapped(log.content.messages, log.robot);
  const Trajectory by_counts = mapped(drive.messages, drive.robot);
  ASSERT_GT(by_counts.path_length_m(), 3.0);
  const auto [metres, radians] = farthest_apart(by_counts, by_joints);
  EXPECT_LT(metres, 0.005);
  EXPECT_LT(radians, 0.005);
}

TEST(WheelJoints, ASimulatedDriveIsTheSameAsByItsOwnCounts) {
  SimulationOptions options;
  options.duration_s = 40.0;
  options.start_s = test::kToday;
  options.laser.beams = 11;
  const auto drive = test::simulate_log("office", 3, options);
  const ToldTopics told = joints_of(drive, 0.11);
  const ToldLog log = read_told(told);
  EXPECT_NEAR(log.robot.wheels.track_width_m, drive.robot.wheels.track_width_m, 1e-9);
  for (const YawSource yaw : {YawSource::kWheels, YawSource::kGyro}) {
    DeadReckoner by_counts(drive.robot.wheels, {.yaw = yaw});
    for (const SensorMessage& message : drive.messages) by_counts.add(message);
    DeadReckoner by_joints(log.robot.wheels, {.yaw = yaw});
    for (const SensorMessage& message : log.content.messages) by_joints.add(message);
    const Trajectory counted = by_counts.finish().trajectory;
    const DeadReckoningResult joints = by_joints.finish();
    EXPECT_GT(joints.wheel_readings, 1000);
    ASSERT_GT(counted.path_length_m(), 10.0);
    const auto [farthest_m, most_turned] = farthest_apart(counted, joints.trajectory);
    EXPECT_LT(farthest_m, 1e-3);
    EXPECT_LT(most_turned, 1e-4);
  }
}

}  // namespace
}  // namespace loopstone
