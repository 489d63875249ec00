#include "loopstone/mapping/floor_texture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/linear_light.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/floor_recording.hpp"
#include "support/rendered_floor.hpp"

namespace loopstone {
namespace {

using test::at_s;
using test::coarse;
using test::Recording;
using test::Score;
using test::score;
using test::winding;

TEST(FloorTexture, IsTheFloor) {
  Recording recording;
  recording.trajectory = winding(4.0);
  const FloorTexture texture =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, coarse());
  const Score found = score(texture, recording.scene.colour);
  EXPECT_GT(found.psnr_db, 33.0);
  EXPECT_GT(found.cells, 2000);
  EXPECT_TRUE(texture.complete);
  EXPECT_NEAR(texture.statistics.seen_area_m2, 4e-4 * static_cast<double>(found.cells), 1e-6);
  EXPECT_EQ(texture.statistics.frames_used, texture.statistics.frames);
  EXPECT_EQ(texture.floor.status, FloorStatus::kEstimated);
  EXPECT_LT(std::abs(degrees(texture.floor.pitch_error_rad)), 0.05);
}

TEST(FloorTexture, CorrectsTheMountAndIsWorseWithout) {
  Recording recording;
  recording.trajectory = winding(3.0);
  CameraModel given = recording.truth;
  recording.truth.robot_T_camera =
      Pose3::from_roll_pitch_yaw({0.18, 0.005, 0.365}, radians(0.5), 0.36 + radians(1.0), 0.021);
  const FloorTexture texture =
      map_floor_texture(recording.source(10.0), recording.trajectory, given, coarse());
  EXPECT_NEAR(degrees(texture.floor.pitch_error_rad), 1.0, 0.05);
  EXPECT_NEAR(degrees(texture.floor.roll_error_rad), 0.5, 0.05);
  EXPECT_NEAR(texture.floor.height_error_m, 0.005, 0.001);
  EXPECT_GT(score(texture, recording.scene.colour).psnr_db, 32.0);
  TextureOptions trusting = coarse();
  trusting.correct_mount = false;
  const FloorTexture trusted =
      map_floor_texture(recording.source(10.0), recording.trajectory, given, trusting);
  EXPECT_LT(score(trusted, recording.scene.colour).psnr_db, 28.0);
}

TEST(FloorTexture, FindsAndCorrectsALateClock) {
  for (const double late_s : {0.05, -0.08}) {
    Recording recording;
    recording.trajectory = winding(6.0, 0.9);
    recording.late_s = late_s;
    const RgbdSource source = recording.source(10.0);
    const FloorTexture texture =
        map_floor_texture(source, recording.trajectory, recording.truth, coarse());
    EXPECT_EQ(texture.clock.status, ClockStatus::kEstimated);
    EXPECT_TRUE(texture.clock.is_significant());
    EXPECT_NEAR(texture.clock.late_s, late_s, 0.005);
    EXPECT_LT(texture.clock.sigma_s, 0.004);
    EXPECT_GT(score(texture, recording.scene.colour).psnr_db, 30.0);
    ASSERT_FALSE(texture.warnings.empty());
    EXPECT_NE(texture.warnings.front().find("stamps"), std::string::npos);
    TextureOptions trusting = coarse();
    trusting.correct_clock = false;
    const FloorTexture trusted =
        map_floor_texture(source, recording.trajectory, recording.truth, trusting);
    EXPECT_LT(score(trusted, recording.scene.colour).psnr_db, 27.0);
  }
}

TEST(FloorTexture, ATrueClockIsLeftAlone) {
  Recording recording;
  recording.trajectory = winding(6.0, 0.9);
  const CameraClock clock =
      estimate_camera_clock(recording.source(10.0), recording.trajectory, recording.truth);
  EXPECT_EQ(clock.status, ClockStatus::kEstimated);
  EXPECT_NEAR(clock.late_s, 0.0, 0.003);
}

TEST(FloorTexture, ClockIsNotObservedOnAStraightDriveOrABareFloor) {
  Recording straight;
  straight.trajectory = winding(6.0, 0.0);
  EXPECT_EQ(
      estimate_camera_clock(straight.source(10.0), straight.trajectory, straight.truth).status,
      ClockStatus::kNotObserved);
  Recording bare;
  bare.scene.colour = [](double, double) { return Eigen::Vector3d(0.4, 0.5, 0.6); };
  bare.trajectory = winding(6.0, 0.9);
  EXPECT_EQ(estimate_camera_clock(bare.source(10.0), bare.trajectory, bare.truth).status,
            ClockStatus::kNotObserved);
}

TEST(FloorTexture, PosesAreThoseOfEachPicturesOwnStamp) {
  Recording recording;
  recording.trajectory = winding(4.0);
  recording.colour_delay_s = 0.04;
  const RgbdSource source = recording.source(10.0);
  TextureOptions options = coarse();
  options.correct_clock = false;
  const FloorTexture texture =
      map_floor_texture(source, recording.trajectory, recording.truth, options);
  EXPECT_GT(score(texture, recording.scene.colour).psnr_db, 32.0);
  RgbdSource mistaken = source;
  for (RgbdFrame& frame : mistaken.frames) frame.colour_stamp = frame.stamp;
  mistaken.load = [&](const RgbdFrame& frame) {
    RgbdFrame right = frame;
    right.colour_stamp = frame.stamp + Duration::from_seconds(0.04);
    return source.load(right);
  };
  const FloorTexture wrong =
      map_floor_texture(mistaken, recording.trajectory, recording.truth, options);
  EXPECT_LT(score(wrong, recording.scene.colour).psnr_db, 30.0);
}

TEST(FloorTexture, ThingsThatStandOnTheFloorLeaveNoColour) {
  Recording recording;
  recording.trajectory = winding(4.0);
  // Red boxes beside the path: where the colour camera sees them the depth camera, 2.6 cm to the
  // left, may see floor.
  for (const double x : {0.9, 1.3, 1.7}) {
    recording.scene.boxes.push_back({{x, -0.15, 0.0}, {x + 0.1, -0.05, 0.3}});
    recording.scene.boxes.push_back({{x, 0.75, 0.0}, {x + 0.1, 0.85, 0.3}});
  }
  const FloorTexture texture =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, coarse());
  std::int64_t seen = 0;
  std::int64_t red = 0;
  for (int row = 0; row < texture.frame.rows; ++row) {
    for (int column = 0; column < texture.frame.columns; ++column) {
      const TextureColour colour = texture.at({column, row});
      if (colour.coverage != TextureColour::kSeen) continue;
      ++seen;
      if (colour.red > 180 && colour.green < 80 && colour.blue < 80) ++red;
    }
  }
  EXPECT_GT(seen, 2000);
  EXPECT_LE(red, seen / 1000);
}

TEST(FloorTexture, BrightnessIsLevelled) {
  Recording recording;
  recording.trajectory = winding(4.0);
  recording.gain = [](Stamp stamp) { return 1.0 + 0.25 * std::sin(7.0 * stamp.seconds()); };
  TextureOptions options = coarse();
  options.correct_clock = false;
  const FloorTexture levelled =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, options);
  options.level_exposure = false;
  const FloorTexture plain =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, options);
  EXPECT_GT(levelled.statistics.gain_spread, 0.1);
  // The first frame's brightness is the level; compare what is left when the best common gain is
  // taken out.
  const auto after_gain = [&](const FloorTexture& texture) {
    double best = 0.0;
    for (double gain = 0.75; gain < 1.3; gain += 0.01) {
      best = std::max(best, score(texture, [&](double x, double y) {
                              return Eigen::Vector3d((gain * test::wavy_floor(x, y)).cwiseMin(1.0));
                            }).psnr_db);
    }
    return best;
  };
  EXPECT_GT(after_gain(levelled), after_gain(plain) + 2.0);
  EXPECT_GT(after_gain(levelled), 30.0);
}

TEST(FloorTexture, DistortedAndRegisteredPicturesGiveTheSameFloor) {
  Recording recording;
  recording.trajectory = winding(3.0);
  recording.truth.colour.k1 = -0.2;
  recording.truth.colour.p1 = 0.002;
  recording.truth.depth.k1 = 0.05;
  TextureOptions options = coarse();
  const FloorTexture distorted =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, options);
  EXPECT_GT(score(distorted, recording.scene.colour).psnr_db, 32.0);
  Recording registered;
  registered.trajectory = winding(3.0);
  registered.truth.colour_is_registered = true;
  const FloorTexture same =
      map_floor_texture(registered.source(10.0), registered.trajectory, registered.truth, options);
  EXPECT_GT(score(same, registered.scene.colour).psnr_db, 33.0);
}

TEST(FloorTexture, SameBytesForOneAndManyThreads) {
  Recording recording;
  recording.trajectory = winding(4.0);
  recording.late_s = 0.03;
  const RgbdSource source = recording.source(10.0);
  const auto texture_by = [&](int threads) {
    return map_floor_texture(source, recording.trajectory, recording.truth, coarse(), {threads});
  };
  const FloorTexture one = texture_by(1);
  const FloorTexture many = texture_by(5);
  ASSERT_EQ(one.frame, many.frame);
  EXPECT_EQ(one.clock.late_s, many.clock.late_s);
  EXPECT_EQ(one.floor.pitch_error_rad, many.floor.pitch_error_rad);
  for (int row = 0; row < one.frame.rows; ++row) {
    for (int column = 0; column < one.frame.columns; ++column) {
      ASSERT_EQ(one.at({column, row}), many.at({column, row}));
    }
  }
}

TEST(FloorTexture, GapsAreFilledOnlyBetweenSeenCells) {
  Recording recording;
  recording.trajectory = winding(5.0);
  const RgbdSource source = recording.source(5.0);
  // A stripe of the picture 3 px wide has no depth.
  RgbdSource holed = source;
  holed.load = [&](const RgbdFrame& frame) {
    RgbdImages images = source.load(frame);
    for (int row = 0; row < images.depth.height; ++row) {
      for (int column = 80; column < 88; ++column) {
        images.depth.per_m[static_cast<std::size_t>(row * images.depth.width + column)] = 0.0F;
      }
    }
    return images;
  };
  holed.frames.resize(1);
  TextureOptions options = coarse();
  options.correct_clock = false;
  const FloorTexture filled =
      map_floor_texture(holed, recording.trajectory, recording.truth, options);
  options.fill_gap_m = 0.0;
  const FloorTexture open =
      map_floor_texture(holed, recording.trajectory, recording.truth, options);
  EXPECT_EQ(open.statistics.filled_area_m2, 0.0);
  EXPECT_GT(filled.statistics.filled_area_m2, 0.0);
  EXPECT_EQ(filled.statistics.seen_area_m2, open.statistics.seen_area_m2);
  ASSERT_EQ(filled.frame, open.frame);  // nothing grows at the edges
  for (int row = 0; row < filled.frame.rows; ++row) {
    for (int column = 0; column < filled.frame.columns; ++column) {
      const TextureColour colour = filled.at({column, row});
      if (colour.coverage != TextureColour::kFilled) continue;
      const Eigen::Vector2d at = filled.frame.centre_of({column, row});
      const double truth = 255.0 * srgb_of_linear(test::wavy_floor(at.x(), at.y()).y());
      EXPECT_NEAR(colour.green, truth, 60.0);
    }
  }
}

TEST(FloorTexture, FramesThatCannotBeUsedAreCounted) {
  Recording recording;
  recording.trajectory = winding(3.0);
  RgbdSource source = recording.source(10.0);
  const auto good = source.load;
  const auto count = static_cast<std::int64_t>(source.frames.size());
  source.frames.insert(source.frames.begin(), {at_s(50.0), at_s(50.0), "c", "d"});
  source.frames.push_back({at_s(200.0), at_s(200.0), "c", "d"});
  source.frames.push_back({at_s(101.0), at_s(101.0), "", "d"});  // no colour: not a frame
  source.load = [&](const RgbdFrame& frame) {
    if (frame.stamp == at_s(101.0)) throw DataError({"d"}, "is damaged");
    return good(frame);
  };
  const FloorTexture texture =
      map_floor_texture(source, recording.trajectory, recording.truth, coarse());
  EXPECT_EQ(texture.statistics.frames, count + 2);
  EXPECT_EQ(texture.statistics.frames_without_pose, 2);
  EXPECT_EQ(texture.statistics.frames_unreadable, 1);
  EXPECT_EQ(texture.statistics.frames_used, count - 1);
  EXPECT_FALSE(texture.warnings.empty());

  RgbdSource nothing;
  const FloorTexture empty =
      map_floor_texture(nothing, recording.trajectory, recording.truth, coarse());
  EXPECT_EQ(empty.frame.cell_count(), 0U);
  EXPECT_EQ(empty.statistics.frames, 0);
}

TEST(FloorTexture, AStandingRobotAddsNothing) {
  Recording recording;
  for (double t = 100.0; t < 110.0; t += 0.1) recording.trajectory.append(at_s(t), Pose2{});
  const FloorTexture texture =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, coarse());
  EXPECT_EQ(texture.statistics.frames_used, 1);
  EXPECT_EQ(texture.statistics.frames_still, texture.statistics.frames - 1);
}

TEST(FloorTexture, StopsWhenAsked) {
  Recording recording;
  recording.trajectory = winding(3.0);
  int calls = 0;
  const FloorTexture texture =
      map_floor_texture(recording.source(10.0), recording.trajectory, recording.truth, coarse(),
                        {1}, [&](const Progress&) { return ++calls < 3; });
  EXPECT_FALSE(texture.complete);
  EXPECT_GT(texture.statistics.frames_used, 0);
  EXPECT_LT(texture.statistics.frames_used, texture.statistics.frames);
}

}  // namespace
}  // namespace loopstone
