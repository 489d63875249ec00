#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "loopstone/base/rng.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "support/floor_recording.hpp"

namespace loopstone {
namespace {

/// The drive as a laser's trajectory tells it: each pose is a little off, but for those of the
/// first frames, which say where the texture lies.
Trajectory jittered(const Trajectory& truth, double jitter_m, double jitter_rad,
                    std::uint64_t seed) {
  Rng rng(seed);
  Trajectory made;
  for (const StampedPose2& stamped : truth.poses()) {
    if (stamped.stamp - truth.front().stamp < Duration::from_seconds(0.35)) {
      made.append(stamped.stamp, stamped.pose);
      continue;
    }
    made.append(stamped.stamp, {stamped.pose.x + rng.normal(0.0, jitter_m),
                                stamped.pose.y + rng.normal(0.0, jitter_m),
                                stamped.pose.yaw + rng.normal(0.0, jitter_rad)});
  }
  return made;
}

/// Structure of 6 cm, which millimetres blur.
Eigen::Vector3d fine_floor(double x, double y) {
  const double a = 0.5 + 0.2 * std::sin(101.0 * x + 14.0 * y) + 0.2 * std::sin(93.0 * y - 29.0 * x);
  return {a, 0.8 * a, 0.5 + 0.3 * std::sin(3.1 * x) * std::cos(2.3 * y)};
}

test::Recording fine_recording(double duration_s) {
  test::Recording recording;
  recording.scene.colour = fine_floor;
  // Frames are aligned when they share some hundred sharp cells: half of a Kinect's pixels a side.
  for (LensModel* lens : {&recording.truth.depth, &recording.truth.colour}) {
    lens->focal_x_px *= 2.0;
    lens->focal_y_px *= 2.0;
    lens->centre_x_px = 2.0 * lens->centre_x_px + 0.5;
    lens->centre_y_px = 2.0 * lens->centre_y_px + 0.5;
    lens->width_px *= 2;
    lens->height_px *= 2;
  }
  recording.trajectory = test::winding(duration_s);
  return recording;
}

double psnr_db(const test::Recording& recording, const RgbdSource& source,
               const Trajectory& trajectory, bool refine) {
  TextureOptions options = test::coarse();
  options.resolution_m = 0.015;
  options.max_blur_m = 0.03;
  options.correct_clock = false;
  options.refine_poses = refine;
  return test::score(map_floor_texture(source, trajectory, recording.truth, options),
                     recording.scene.colour)
      .psnr_db;
}

TEST(TextureRefinement, FramesAtPosesThatAreOffAgreeAgain) {
  const test::Recording recording = fine_recording(3.0);
  const RgbdSource source = recording.source(10.0);
  for (const std::uint64_t seed : {1U, 2U}) {
    const Trajectory given = jittered(recording.trajectory, 0.003, radians(0.1), seed);
    const double plain = psnr_db(recording, source, given, false);
    const double refined = psnr_db(recording, source, given, true);
    EXPECT_GT(refined, plain + 0.7) << plain << " dB without";
  }
}

TEST(TextureRefinement, ExactPosesAreLeftWhereTheyAre) {
  const test::Recording recording = fine_recording(3.0);
  const RgbdSource source = recording.source(10.0);
  const double plain = psnr_db(recording, source, recording.trajectory, false);
  const double refined = psnr_db(recording, source, recording.trajectory, true);
  EXPECT_GT(refined, plain - 0.3) << plain << " dB without";
}

TEST(TextureRefinement, ABareFloorHoldsNothing) {
  // Nothing to align to: the poses stay those given, and the colour is the floor's.
  test::Recording recording = fine_recording(1.5);
  recording.scene.colour = [](double, double) { return Eigen::Vector3d(0.2, 0.4, 0.3); };
  const RgbdSource source = recording.source(10.0);
  const Trajectory given = jittered(recording.trajectory, 0.003, radians(0.1), 3);
  EXPECT_GT(psnr_db(recording, source, given, true), 45.0);
}

}  // namespace
}  // namespace loopstone
