#include "simulation/rgbd_sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "loopstone/simulation/simulate.hpp"

namespace loopstone {
namespace {

std::shared_ptr<const FloorPattern> grey_floor(float light) {
  const std::vector<LinearColour> texels(4, LinearColour::Constant(light));
  return std::make_shared<const FloorPattern>(2, 2, Eigen::Vector2d(1.0, 1.0), texels);
}

/// A quarter of the Kinect's pixels.
RobotModel small_robot() {
  RobotModel robot;
  for (LensModel* lens : {&robot.camera.depth, &robot.camera.colour}) {
    lens->focal_x_px /= 4.0;
    lens->focal_y_px /= 4.0;
    lens->centre_x_px /= 4.0;
    lens->centre_y_px /= 4.0;
    lens->width_px = 160;
    lens->height_px = 120;
  }
  return robot;
}

SimulationOptions perfect_camera() {
  SimulationOptions options;
  options.duration_s = 4.5;
  options.laser.beams = 19;
  options.camera.pitch_error_rad = options.camera.roll_error_rad = 0.0;
  options.camera.height_error_m = 0.0;
  options.camera.depth = {0.0, 0.0, 0.0, 0.0};
  options.camera.colour = {0.0, 0.0, 0.0, 0.0, 0.0};
  return options;
}

struct Recorded {
  std::vector<SimulatedFrame> frames{};
  std::vector<SensorMessage> messages{};
  SimulationSummary summary{};

  [[nodiscard]] std::vector<RgbdFrame> frame_messages() const {
    std::vector<RgbdFrame> found;
    for (const SensorMessage& message : messages) {
      if (const auto* frame = std::get_if<RgbdFrame>(&message)) found.push_back(*frame);
    }
    return found;
  }
};

World grey_office() {
  World world = make_world("office", 1);
  world.floor = grey_floor(0.3F);
  return world;
}

/// Three seconds of rest, two of a slow curve, then rest again.
Drive short_drive(const World& world, double duration_s) {
  Drive drive(world.map_T_start);
  while (drive.duration_s() < duration_s) {
    const bool moves = drive.duration_s() > 3.0 && drive.duration_s() < 5.0;
    drive.append(moves ? 0.3 : 0.0, moves ? 0.2 : 0.0);
  }
  return drive;
}

Recorded record(const SimulationOptions& options, bool with_camera = true) {
  static const World world = grey_office();
  Recorded recorded;
  SimulationSink sink;
  if (with_camera) {
    sink.frame = [&](const SimulatedFrame& frame) -> RgbdFrame {
      recorded.frames.push_back(frame);
      return {frame.depth_stamp, frame.colour_stamp, "colour", "depth"};
    };
  }
  sink.message = [&](SensorMessage message) { recorded.messages.push_back(std::move(message)); };
  recorded.summary = simulate_drive(world, short_drive(world, options.duration_s), small_robot(),
                                    options, 7, sink);
  return recorded;
}

struct Spread {
  double mean = 0.0;
  double deviation = 0.0;
};

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  for (const double v : values) spread.mean += v / static_cast<double>(values.size());
  for (const double v : values) {
    spread.deviation += (v - spread.mean) * (v - spread.mean) / static_cast<double>(values.size());
  }
  spread.deviation = std::sqrt(spread.deviation);
  return spread;
}

TEST(RgbdSensor, FramesComeAtTheirRateInOrderWithTheirStamps) {
  SimulationOptions options = perfect_camera();
  options.camera.colour.lag_s = 0.02;
  const Recorded log = record(options);
  ASSERT_NEAR(static_cast<double>(log.frames.size()), 22.0, 1.0);
  EXPECT_EQ(log.summary.frames, static_cast<std::int64_t>(log.frames.size()));
  EXPECT_EQ(log.frame_messages().size(), log.frames.size());
  for (std::size_t i = 0; i < log.frames.size(); ++i) {
    const SimulatedFrame& frame = log.frames[i];
    EXPECT_EQ(frame.index, static_cast<std::int64_t>(i));
    EXPECT_EQ(frame.depth.numbers.size(), 160U * 120U);
    EXPECT_EQ(frame.colour.rgb.size(), 3U * 160U * 120U);
    EXPECT_NEAR((frame.colour_stamp - frame.depth_stamp).seconds(), 0.02, 1e-9);
    if (i > 0) {
      EXPECT_NEAR((frame.depth_stamp - log.frames[i - 1].depth_stamp).seconds(), 0.2, 2e-6);
    }
  }
  Stamp last{};
  for (const SensorMessage& message : log.messages) {
    EXPECT_LE(last, stamp_of(message));
    last = stamp_of(message);
  }
}

TEST(RgbdSensor, SameArgumentsSamePicturesAndOtherSensorsDoNotNotice) {
  SimulationOptions options;
  options.duration_s = 1.5;
  options.people = 2;
  const Recorded first = record(options);
  const Recorded second = record(options);
  const Recorded without = record(options, false);
  ASSERT_EQ(first.frames.size(), second.frames.size());
  for (std::size_t i = 0; i < first.frames.size(); ++i) {
    EXPECT_EQ(first.frames[i].depth.numbers, second.frames[i].depth.numbers);
    EXPECT_EQ(first.frames[i].colour.rgb, second.frames[i].colour.rgb);
  }
  EXPECT_NE(first.frames[0].colour.rgb, first.frames[1].colour.rgb) << "noise must differ";
  std::size_t i = 0;
  for (const SensorMessage& message : first.messages) {
    if (std::holds_alternative<RgbdFrame>(message)) continue;
    ASSERT_LT(i, without.messages.size());
    const SensorMessage& other = without.messages[i++];
    ASSERT_EQ(message.index(), other.index());
    EXPECT_EQ(stamp_of(message), stamp_of(other));
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      const auto& ranges = std::get<LaserScan>(other).ranges_m;
      ASSERT_EQ(scan->ranges_m.size(), ranges.size());
      for (std::size_t b = 0; b < ranges.size(); ++b) {
        EXPECT_TRUE(scan->ranges_m[b] == ranges[b] || std::isnan(ranges[b]));
      }
    }
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
      EXPECT_EQ(ticks->counts, std::get<WheelTicks>(other).counts);
    }
    if (const auto* imu = std::get_if<ImuSample>(&message)) {
      EXPECT_EQ(imu->angular_velocity_rad_s, std::get<ImuSample>(other).angular_velocity_rad_s);
    }
  }
  EXPECT_EQ(i, without.messages.size());
}

TEST(RgbdSensor, AClockOffsetDelaysStampsButNotPictures) {
  SimulationOptions options = perfect_camera();
  const Recorded prompt = record(options);
  options.camera.clock_offset_s = 0.05;
  const Recorded late = record(options);
  ASSERT_GE(late.frames.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(late.frames[i].colour.rgb, prompt.frames[i].colour.rgb);
    EXPECT_EQ(late.frames[i].depth.numbers, prompt.frames[i].depth.numbers);
    const SimulatedFrame& frame = late.frames[i];
    EXPECT_NEAR((frame.depth_stamp - prompt.frames[i].depth_stamp).seconds(), 0.05, 1e-9);
    EXPECT_NEAR((frame.colour_stamp - prompt.frames[i].colour_stamp).seconds(), 0.05, 1e-9);
  }
}

TEST(RgbdSensor, WithoutNoiseNumbersAreTheRoundedTrueDisparities) {
  const Recorded log = record(perfect_camera());
  const RobotModel robot = small_robot();
  const World world = grey_office();
  const SurfaceIndex surfaces(world.plan);
  const CameraRenderer renderer(world, surfaces, robot.camera);
  const TrueDepth seen = renderer.depth(world.map_T_start);  // it stands still for 3 s
  int compared = 0;
  for (std::size_t i = 0; i < seen.depth.per_m.size(); ++i) {
    const auto inverse = static_cast<double>(seen.depth.per_m[i]);
    const std::uint16_t number = log.frames[2].depth.numbers[i];
    if (inverse < 0.1 || inverse > 2.5) {
      if (inverse < 0.0995 || inverse > 2.51) {
        EXPECT_EQ(number, 0);
      }
      continue;
    }
    const double exact = (1.03 * inverse - 3.31) / -0.00304;
    EXPECT_NEAR(static_cast<double>(number), exact, 0.5 + 1e-2);
    ++compared;
  }
  EXPECT_GT(compared, 10000);
}

TEST(RgbdSensor, DisparitiesHaveTheNoiseAndTheGapsThatWereAskedFor) {
  SimulationOptions options = perfect_camera();
  const Recorded clean = record(options);
  options.camera.depth.noise_steps = 2.0;
  options.camera.depth.dropout_probability = 0.1;
  const Recorded noisy = record(options);
  std::vector<double> errors;
  double lost = 0.0;
  double all = 0.0;
  for (std::size_t f = 0; f < 5; ++f) {
    for (std::size_t i = 0; i < clean.frames[f].depth.numbers.size(); ++i) {
      if (clean.frames[f].depth.numbers[i] == 0) continue;
      all += 1.0;
      const std::uint16_t number = noisy.frames[f].depth.numbers[i];
      if (number == 0) {
        lost += 1.0;
      } else {
        errors.push_back(number - static_cast<double>(clean.frames[f].depth.numbers[i]));
      }
    }
  }
  const Spread spread = spread_of(errors);
  EXPECT_NEAR(spread.mean, 0.0, 0.02);
  EXPECT_NEAR(spread.deviation, std::sqrt(4.0 + 2.0 / 12.0), 0.05);  // both are rounded
  EXPECT_NEAR(lost / all, 0.1, 0.005);
}

TEST(RgbdSensor, DepthIsLostBesideNearThingsAndOnGrazedFloor) {
  World world;
  world.plan.circles.push_back({{0.9, 0.0}, 0.06});
  world.plan.boxes.push_back({{2.5, 0.0, 0.5 * kPi}, 8.0, 0.2, true});
  world.floor = grey_floor(0.3F);
  const SurfaceIndex surfaces(world.plan);
  Drive drive(Pose2{});
  const Crowd nobody(world, drive, 0, Rng(1));
  CameraModel camera = small_robot().camera;
  camera.robot_T_camera = Pose3{{0.0, 0.0, 0.4}, Eigen::Quaterniond::Identity()};
  SimulatedCamera options = perfect_camera().camera;
  options.depth.projector_baseline_m = 0.075;
  RgbdSensor sensor(world, drive, surfaces, nobody, camera, options, Rng(1));
  const RawDepthImage image = sensor.depth_at(0.0);
  // The projector sits on the right, so the shadow on the wall (2.4 m) lies left of the pole (0.84
  // m): 146 px times 0.075 m (1 / 0.84 - 1 / 2.4) = 8.5 px.
  const int row = 60;
  std::vector<int> dark;
  for (int column = 0; column < 160; ++column) {
    if (image.numbers[static_cast<std::size_t>(row * 160 + column)] == 0) dark.push_back(column);
  }
  EXPECT_NEAR(static_cast<double>(dark.size()), 8.5, 1.6);
  EXPECT_LT(dark.back(), 79);
  EXPECT_GT(dark.front(), 79 - 10 - 12);

  // Depth fails on floor that is seen under less than 6 deg, and more the farther.
  world.plan = {};
  world.plan.boxes.push_back({{30.0, 0.0, 0.5 * kPi}, 8.0, 0.2, true});
  const SurfaceIndex far(world.plan);
  options.depth.grazing_dropout = 1.0;
  RgbdSensor open(world, drive, far, nobody, camera, options, Rng(1));
  const RawDepthImage floor = open.depth_at(0.0);
  const auto kept = [&](int at_row) {
    int count = 0;
    for (int column = 0; column < 160; ++column) {
      if (floor.numbers[static_cast<std::size_t>(at_row * 160 + column)] != 0) ++count;
    }
    return count / 160.0;
  };
  EXPECT_GT(kept(100), 0.99);
  // Row 69 is 8.3 px below the axis: 3.2 deg, cosine 0.056.
  EXPECT_NEAR(kept(69), 0.56, 0.15);
}

TEST(RgbdSensor, ColoursHaveTheNoiseAndTheExposureThatWasAskedFor) {
  SimulationOptions options = perfect_camera();
  options.duration_s = 40.0;
  options.camera.colour.noise_levels = 3.0;
  options.camera.colour.gain_wander = 0.1;
  options.camera.rate_hz = 2.0;
  const Recorded log = record(options);
  std::vector<double> gains;
  std::vector<double> errors;
  for (const SimulatedFrame& frame : log.frames) {
    double sum = 0.0;
    std::vector<double> values;
    for (int row = 110; row < 120; ++row) {  // the floor right before the robot
      for (int column = 60; column < 100; ++column) values.push_back(*frame.colour.at(column, row));
    }
    const Spread spread = spread_of(values);
    sum = spread.mean;
    errors.push_back(spread.deviation);
    gains.push_back(std::log(linear_of_srgb(sum / 255.0) / 0.3));
  }
  EXPECT_NEAR(spread_of(errors).mean, std::sqrt(9.0 + 1.0 / 12.0), 0.1);
  const Spread gain = spread_of(gains);
  EXPECT_NEAR(gain.mean, 0.0, 0.08);
  EXPECT_NEAR(gain.deviation, 0.1, 0.04);
  // It wanders rather than jumps.
  double steps = 0.0;
  for (std::size_t i = 1; i < gains.size(); ++i) steps += std::abs(gains[i] - gains[i - 1]);
  EXPECT_LT(steps / static_cast<double>(gains.size() - 1), 0.08);
}

TEST(RgbdSensor, CornersAreDarkerByTheVignetting) {
  World world;
  world.plan.boxes.push_back({{300.0, 0.0, 0.0}, 1.0, 1.0, true});
  world.floor = grey_floor(0.4F);
  const SurfaceIndex surfaces(world.plan);
  Drive drive(Pose2{});
  const Crowd nobody(world, drive, 0, Rng(1));
  CameraModel camera = small_robot().camera;
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.4}, 0.0, 0.5 * kPi, 0.0);
  SimulatedCamera options = perfect_camera().camera;
  options.colour.vignetting = 0.3;
  RgbdSensor sensor(world, drive, surfaces, nobody, camera, options, Rng(1));
  const ColourImage image = sensor.colour_at(0.0);
  EXPECT_NEAR(linear_of_srgb(*image.at(79, 61) / 255.0), 0.4, 0.005);
  EXPECT_NEAR(linear_of_srgb(*image.at(0, 0) / 255.0), 0.7 * 0.4, 0.01);
}

TEST(RgbdSensor, MillimetresComeOutWhenTheModelSaysSo) {
  World world;
  world.plan.boxes.push_back({{3.1, 0.0, 0.5 * kPi}, 8.0, 0.2, true});
  world.floor = grey_floor(0.3F);
  const SurfaceIndex surfaces(world.plan);
  Drive drive(Pose2{});
  const Crowd nobody(world, drive, 0, Rng(1));
  CameraModel camera = small_robot().camera;
  camera.robot_T_camera = Pose3{{0.0, 0.0, 0.4}, Eigen::Quaterniond::Identity()};
  camera.encoding.kind = DepthKind::kDepth;
  RgbdSensor sensor(world, drive, surfaces, nobody, camera, perfect_camera().camera, Rng(1));
  EXPECT_EQ(sensor.depth_at(0.0).numbers[60 * 160 + 80], 3000);
}

TEST(QuickNormals, AreNormal) {
  QuickNormals normals(Rng(5));
  double sum = 0.0;
  double squares = 0.0;
  double fourth = 0.0;
  double most = 0.0;
  constexpr int kCount = 400000;
  for (int i = 0; i < kCount; ++i) {
    const auto x = static_cast<double>(normals.next());
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
    most = std::max(most, std::abs(x));
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.01);
  EXPECT_NEAR(squares / kCount, 1.0, 0.01);
  EXPECT_NEAR(fourth / kCount, 3.0, 0.06);
  EXPECT_GT(most, 3.4);
  EXPECT_LT(most, 3.8);
}

}  // namespace
}  // namespace loopstone
