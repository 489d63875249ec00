// Pictures in recordings: from topics to RGB-D frames, and back.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "formats/topic_log.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "support/pose_near.hpp"
#include "support/temp_dir.hpp"
#include "topic_samples.hpp"

namespace loopstone {
namespace {

using test::mount;
using test::opener_of;
using test::TempDir;
using test::today;
using test::ToldTopics;
using testing::Contains;
using testing::HasSubstr;

constexpr int kWidth = 8;
constexpr int kHeight = 6;

msg::CameraInfo info(Stamp stamp, const std::string& frame, double focal_px) {
  msg::CameraInfo message{.header = {stamp, frame},
                          .height = kHeight,
                          .width = kWidth,
                          .distortion_model = "plumb_bob",
                          .d = {0, 0, 0, 0, 0}};
  message.k = {focal_px, 0, 4, 0, focal_px, 3, 0, 0, 1};
  return message;
}

msg::Image colour_picture(Stamp stamp, const std::string& frame, int shade) {
  msg::Image message{.header = {stamp, frame},
                     .height = kHeight,
                     .width = kWidth,
                     .encoding = "rgb8",
                     .step = 3 * kWidth};
  message.data.assign(std::size_t{3} * kWidth * kHeight, static_cast<std::uint8_t>(shade));
  return message;
}

msg::Image depth_picture(Stamp stamp, const std::string& frame, int mm) {
  msg::Image message{.header = {stamp, frame},
                     .height = kHeight,
                     .width = kWidth,
                     .encoding = "16UC1",
                     .step = 2 * kWidth};
  for (int i = 0; i < kWidth * kHeight; ++i) {
    message.data.push_back(static_cast<std::uint8_t>(mm & 0xFF));
    message.data.push_back(static_cast<std::uint8_t>(mm >> 8));
  }
  return message;
}

/// base_T_optical of a camera half a metre up that looks ahead and 30 deg down.
Pose3 optical_mount(double x = 0.1) {
  return mount(x, 0, 0.5, 0, std::numbers::pi / 6, 0) *
         Pose3{Eigen::Vector3d::Zero(), Eigen::Quaterniond(body_R_optical())};
}

struct CameraRig {
  std::string depth_frame = "depth_optical";
  std::string colour_frame = "colour_optical";
  bool has_tf = true;
  bool has_infos = true;
  bool moves = false;
};

/// A robot with a laser and a camera: depth is told 5 ms after colour.
ToldTopics robot(const CameraRig& rig = {}, int frames = 30) {
  ToldTopics told;
  told.tf("/tf_static", today(0), "base_link", "laser", mount(0.2, 0, 0.3, 0, 0, 0));
  if (rig.has_tf) {
    if (!rig.moves) told.tf("/tf_static", today(0), "base_link", rig.depth_frame, optical_mount());
    if (rig.colour_frame != rig.depth_frame) {
      told.tf("/tf_static", today(0), rig.depth_frame, rig.colour_frame,
              mount(0.025, 0, 0, 0, 0, 0));
    }
  }
  for (int i = 0; i < frames; ++i) {
    const double t = 0.1 * i;
    if (rig.moves) {
      told.tf("/tf", today(t - 0.05), "base_link", rig.depth_frame, optical_mount(0.1 + 0.01 * i));
    }
    told.odometry("/odom", today(t), mount(0.05 * i, 0, 0, 0, 0, 0));
    told.scan("/scan", today(t + 0.01), "laser");
    const Stamp colour = today(t + 0.02);
    const Stamp depth = today(t + 0.025);
    told.add("/cam/rgb/image_raw", colour, colour_picture(colour, rig.colour_frame, 10 + i));
    told.add("/cam/depth/image_raw", depth, depth_picture(depth, rig.depth_frame, 1000 + i));
    if (rig.has_infos) {
      told.add("/cam/rgb/camera_info", colour, info(colour, rig.colour_frame, 11));
      told.add("/cam/depth/camera_info", depth, info(depth, rig.depth_frame, 9));
    }
  }
  return told;
}

/// A log with its pictures.
struct Seen {
  std::vector<RgbdFrame> frames{};
  std::shared_ptr<const PictureStore> pictures{};
  RobotModel robot{};
  std::string fault{};
  std::vector<std::string> choices{};
  std::vector<std::string> notes{};
  std::vector<TopicSummary> topics{};

  [[nodiscard]] std::string role_of(const std::string& name) const {
    for (const TopicSummary& topic : topics) {
      if (topic.name == name) return std::string(to_string(topic.role));
    }
    return "missing";
  }
};

/// \param told  must outlive the pictures
Seen see(const ToldTopics& told, LogOptions options = {.topics = {.pictures = true}}) {
  Seen seen;
  const auto reader = open_topic_log("told", opener_of(told), options);
  Stamp last{};
  while (auto message = reader->next()) {
    EXPECT_GE(stamp_of(*message), last);
    last = stamp_of(*message);
    if (const auto* frame = std::get_if<RgbdFrame>(&*message)) seen.frames.push_back(*frame);
  }
  seen.pictures = reader->pictures();
  seen.robot = reader->robot({});
  seen.fault = reader->camera_fault();
  seen.choices = reader->choices();
  seen.notes = reader->notes();
  seen.topics = reader->topics();
  return seen;
}

TEST(TopicCamera, FramesComeWithLensAndMount) {
  const ToldTopics told = robot();
  const Seen seen = see(told);
  ASSERT_EQ(seen.frames.size(), 30U);
  EXPECT_EQ(seen.fault, "");
  EXPECT_TRUE(seen.notes.empty()) << seen.notes.front();
  const CameraModel& camera = seen.robot.camera;
  EXPECT_EQ(camera.depth.focal_x_px, 9);
  EXPECT_EQ(camera.colour.focal_x_px, 11);
  EXPECT_FALSE(camera.colour_is_registered);
  EXPECT_EQ(camera.encoding.kind, DepthKind::kDepth);
  const Eigen::Vector3d angles = to_roll_pitch_yaw(camera.robot_T_camera);
  EXPECT_NEAR(angles.x(), 0.0, 1e-9);
  EXPECT_NEAR(angles.y(), std::numbers::pi / 6, 1e-9);
  EXPECT_NEAR(camera.robot_T_camera.translation.z(), 0.5, 1e-9);
  // 25 mm along the depth camera's optical x axis, which points to the right.
  EXPECT_NEAR(camera.camera_T_colour.translation.y(), -0.025, 1e-9);
  EXPECT_NEAR(camera.camera_T_colour.translation.x(), 0.0, 1e-9);

  const RgbdFrame& frame = seen.frames[7];
  EXPECT_EQ(frame.stamp, today(0.725));
  EXPECT_EQ(frame.colour_stamp, today(0.72));
  EXPECT_FALSE(frame.robot_T_camera.has_value());
  const RgbdImages images = RgbdLoader(camera, seen.pictures).load(frame);
  EXPECT_EQ(images.colour.at(3, 2)[1], 17);
  EXPECT_NEAR(images.depth.at(3, 2), 1.0 / 1.007, 1e-6);
  EXPECT_THAT(seen.choices, Contains(HasSubstr("looks 30 deg down")));
  EXPECT_EQ(seen.role_of("/cam/depth/image_raw"), "depth");
  EXPECT_EQ(seen.role_of("/cam/rgb/image_raw"), "colour");
}

TEST(TopicCamera, NobodyAskedNobodyLooks) {
  const Seen seen = see(robot(), {});
  EXPECT_TRUE(seen.frames.empty());
  EXPECT_EQ(seen.role_of("/cam/depth/image_raw"), "none");
}

TEST(TopicCamera, WhatIsNotToldIsSaid) {
  EXPECT_THAT(see(robot({.has_tf = false})).fault, HasSubstr("no tf tells"));
  EXPECT_THAT(see(robot({.has_infos = false})).fault, HasSubstr("no CameraInfo"));
  // The frames come all the same: a robot file may know better.
  EXPECT_EQ(see(robot({.has_infos = false})).frames.size(), 30U);
}

TEST(TopicCamera, RegisteredPicturesShareAFrame) {
  ToldTopics told = robot({.colour_frame = "depth_optical"});
  const Seen both = see(told);
  EXPECT_EQ(both.fault, "");
  EXPECT_NEAR(both.robot.camera.camera_T_colour.translation.norm(), 0.0, 1e-12);
  // When only one of the two has a CameraInfo, its lens is that of both.
  ToldTopics one;
  one.topics = told.topics;
  for (RecordedTopic& topic : one.topics) {
    if (topic.name == "/cam/depth/camera_info") topic.name = "/other/camera_info";
  }
  for (const auto& message : told.messages) {
    if (one.topics[message.topic].name != "/other/camera_info") one.messages.push_back(message);
  }
  const Seen lonely = see(one);
  EXPECT_EQ(lonely.fault, "");
  EXPECT_EQ(lonely.robot.camera.depth.focal_x_px, 11);
}

TEST(TopicCamera, MountsThatMoveAreThoseOfTheMoment) {
  const Seen seen = see(robot({.moves = true}));
  ASSERT_GE(seen.frames.size(), 28U);
  for (const RgbdFrame& frame : seen.frames) {
    ASSERT_TRUE(frame.robot_T_camera.has_value());
    if (frame.stamp > today(2.85)) continue;  // tf told nothing later
    const double i = ((frame.stamp - today(0)).seconds() + 0.05) / 0.1;
    EXPECT_NEAR(frame.robot_T_camera->translation.x(), 0.1 + 0.01 * i, 1e-6);
  }
}

TEST(TopicCamera, TheUserNamesTopics) {
  ToldTopics told = robot();
  for (int i = 0; i < 30; ++i) {
    const Stamp stamp = today(0.1 * i + 0.02);
    told.add("/back/rgb/image_raw", stamp, colour_picture(stamp, "colour_optical", 200));
  }
  EXPECT_EQ(see(told).role_of("/back/rgb/image_raw"), "none");
  const LogOptions options{
      .topics = {.named = {{TopicRole::kColour, "/back/rgb/image_raw"}}, .pictures = true}};
  EXPECT_EQ(see(told, options).role_of("/back/rgb/image_raw"), "colour");
  const LogOptions none{.topics = {.named = {{TopicRole::kDepth, ""}}, .pictures = true}};
  EXPECT_TRUE(see(told, none).frames.empty());
}

TEST(TopicCamera, TheHeightIsAboveTheFootprint) {
  ToldTopics told = robot();
  told.tf("/tf_static", today(0), "base_footprint", "base_link", mount(0, 0, 0.07, 0, 0, 0));
  // The recorder got it last, but it stands.
  const Seen seen = see(told);
  EXPECT_NEAR(seen.robot.camera.robot_T_camera.translation.z(), 0.57, 1e-9);
}

TEST(TopicCamera, WrittenFramesComeBack) {
  const TempDir folder;
  for (const char* const format : {"mcap", "bag", "rosbag2"}) {
    RobotModel model;  // its depth pictures hold disparities
    model.camera.depth.width_px = model.camera.colour.width_px = kWidth;
    model.camera.depth.height_px = model.camera.colour.height_px = kHeight;
    Image colour = make_image(kWidth, kHeight, 3);
    for (std::size_t i = 0; i < colour.bytes.size(); ++i) {
      colour.bytes[i] = static_cast<std::uint8_t>(i);
    }
    Image depth = make_image(kWidth, kHeight, 1, 2);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const auto number = static_cast<std::uint16_t>(400 + 10 * i);
      std::memcpy(depth.bytes.data() + 2 * i, &number, 2);
    }
    write_png(folder / "colour.png", colour);
    write_png(folder / "depth.png", depth);
    const std::string path = folder / (std::string("log.") + format);
    const auto writer = create_log(path, format, model);
    const int frames = 40;
    for (int i = 0; i < frames; ++i) {
      writer->write(RgbdFrame{.stamp = today(0.1 * i),
                              .colour_stamp = today(0.1 * i + 0.01),
                              .colour_path = folder / "colour.png",
                              .depth_path = folder / "depth.png"});
    }
    writer->finish();

    const auto reader = open_log(path, {.topics = {.pictures = true}});
    std::vector<RgbdFrame> came;
    while (auto message = reader->next()) came.push_back(std::get<RgbdFrame>(*message));
    ASSERT_EQ(came.size(), static_cast<std::size_t>(frames)) << format;
    EXPECT_EQ(reader->camera_fault(), "") << format;
    const RobotModel told = reader->robot({});
    const Pose3 moved = told.camera.robot_T_camera.inverse() * model.camera.robot_T_camera;
    EXPECT_LT(moved.translation.norm(), 1e-9);
    EXPECT_LT(moved.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-9);
    EXPECT_LT(
        (told.camera.camera_T_colour.translation - model.camera.camera_T_colour.translation).norm(),
        1e-9);
    EXPECT_EQ(told.camera.colour.focal_x_px, model.camera.colour.focal_x_px);
    const RgbdImages images = RgbdLoader(told.camera, reader->pictures()).load(came[33]);
    const RgbdImages stored =
        RgbdLoader(model.camera)
            .load({.colour_path = folder / "colour.png", .depth_path = folder / "depth.png"});
    EXPECT_EQ(images.colour.rgb, stored.colour.rgb);
    for (std::size_t i = 0; i < stored.depth.per_m.size(); ++i) {
      const float per_m = stored.depth.per_m[i];
      EXPECT_NEAR(images.depth.per_m[i], per_m, 0.00051 * per_m * per_m + 1e-6) << i;
    }
  }
}

}  // namespace
}  // namespace loopstone
