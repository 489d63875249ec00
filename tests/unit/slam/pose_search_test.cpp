#include "slam/pose_search.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loopstone/mapping/submap.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;

const Pose2 kMount{0.0, 0.0, 0.0};

std::vector<SurfacePoint> surfaces_at(const Pose2& pose, LaserScan& scan, BeamTable& beams) {
  scan = test::scan_from(test::furnished_room(), pose, kMount, {});
  return surface_points(scan, kMount, Tangent2::Zero(), {}, beams);
}

struct Scene {
  FrozenSubmap submap;
  std::vector<Eigen::Vector2d> points;  ///< of a scan from the same place, turned
};

Scene scene_turned_by(double yaw) {
  BeamTable beams;
  LaserScan scan;
  Submap submap{SubmapOptions{}};
  const Pose2 place{1.2, 1.0, 0.5};
  const auto first = surfaces_at(place, scan, beams);
  submap.insert(first, scan, kMount, Pose2{}, beams);
  Scene scene{submap.freeze(), {}};
  for (const auto& point : surfaces_at(place * Pose2{0.0, 0.0, yaw}, scan, beams))
    scene.points.emplace_back(point.position.cast<double>());
  return scene;
}

TEST(PoseSearch, ARobotThatTurnedOnTheSpotIsFoundInASmallWindow) {
  for (const double yaw : {-2.5, -0.9, -0.4, 0.0, 0.6, 1.3}) {
    const Scene scene = scene_turned_by(yaw);
    const MaxPyramid pyramid = scene.submap.search_pyramid({}, 0.3);
    const auto found = search_about_robot(scene.points, pyramid, {Pose2{}, 0.3, kPi}, 0.25);
    ASSERT_TRUE(found.found) << yaw;
    EXPECT_TRUE(pose_near(found.target_T_source, Pose2{0.0, 0.0, yaw}, 0.15, 0.06)) << yaw;
  }
}

TEST(PoseSearch, AgreementIsHighWhereTheScanWasTakenAndLowWhereItContradicts) {
  const Scene scene = scene_turned_by(0.0);
  const MaxPyramid pyramid = scene.submap.search_pyramid({}, 0.3);
  EXPECT_GT(agreement_at(scene.points, pyramid, Pose2{}), 0.7);
  EXPECT_LT(agreement_at(scene.points, pyramid, Pose2{0.3, 0.4, 0.8}), 0.25);
}

TEST(PoseSearch, NothingIsFoundBelowTheLeastScore) {
  const Scene scene = scene_turned_by(0.3);
  const MaxPyramid pyramid = scene.submap.search_pyramid({}, 0.3);
  EXPECT_FALSE(search_about_robot(scene.points, pyramid, {Pose2{}, 0.3, 0.5}, 0.99).found);
}

}  // namespace
}  // namespace loopstone
