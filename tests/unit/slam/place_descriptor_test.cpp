#include "slam/place_descriptor.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "loop_scene.hpp"

namespace loopstone {
namespace {

using test::submap_seen_from;

std::vector<SurfacePoint> turned(std::vector<SurfacePoint> surfaces, const Pose2& pose) {
  const Eigen::Matrix2d rotation = pose.rotation();
  for (auto& surface : surfaces) {
    surface.position = (pose * surface.position.cast<double>().eval()).cast<float>();
    surface.normal = (rotation * surface.normal.cast<double>()).cast<float>();
  }
  return surfaces;
}

const std::vector<Pose2> kFirst{{4.0, 3.0, 0.0}, {4.6, 3.2, 0.8}, {5.2, 3.8, 2.0}};
const std::vector<Pose2> kSecond{{3.4, 2.2, 1.7}, {3.3, 3.0, 2.6}, {4.6, 2.8, 0.2}};

TEST(PlaceDescriptor, IsTheSameInAnyFrame) {
  const auto surfaces = submap_seen_from(test::furnished_room(), kFirst, 0).submap.surfaces;
  const auto looks = describe_place(surfaces);
  ASSERT_FALSE(looks.empty());
  EXPECT_NEAR(std::accumulate(looks.begin(), looks.end(), 0.0), 1.0, 1e-4);
  EXPECT_EQ(place_distance(looks, looks), 0.0);
  // Pairs on the border of two bins may fall into the other one.
  for (const Pose2& pose : {Pose2{3.0, -8.0, 0.7}, Pose2{0.0, 0.0, 3.0}, Pose2{-20.0, 5.0, -1.9}})
    EXPECT_LT(place_distance(looks, describe_place(turned(surfaces, pose))), 0.05);
}

TEST(PlaceDescriptor, AnotherRoomIsFartherThanTheSameOneSeenAgain) {
  const test::Walls other = test::together(
      {test::rectangle({0.0, 0.5}, {5.0, 8.0}), test::rectangle({1.0, 3.5}, {2.2, 4.1}),
       test::rectangle({3.4, 1.0}, {4.1, 1.4}), test::rectangle({2.0, 6.0}, {4.9, 6.3})});
  const auto looks =
      describe_place(submap_seen_from(test::furnished_room(), kFirst, 0).submap.surfaces);
  const auto again =
      describe_place(submap_seen_from(test::furnished_room(), kSecond, 0).submap.surfaces);
  const auto elsewhere = describe_place(
      submap_seen_from(other, {{3.0, 2.5, 1.7}, {3.0, 3.2, 2.6}, {2.6, 2.4, -1.0}}, 0)
          .submap.surfaces);
  EXPECT_LT(place_distance(looks, again), 0.5 * place_distance(looks, elsewhere));
}

TEST(PlaceDescriptor, SaysNothingOfAFewPoints) {
  EXPECT_TRUE(describe_place({}).empty());
  EXPECT_TRUE(describe_place(std::vector<SurfacePoint>(10)).empty());
}

}  // namespace
}  // namespace loopstone
