#include "loopstone/evaluation/relations.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace loopstone {
namespace {

Stamp at(double seconds) { return Stamp::from_seconds(seconds); }

Trajectory path() {
  Trajectory result;
  for (int i = 0; i < 20; ++i) {
    result.append(at(i), {1.0 * i, 0.3 * std::sin(i), 0.2 * i});
  }
  return result;
}

Relation true_relation(const Trajectory& trajectory, double from, double to) {
  return {at(from), at(to), trajectory.at(at(from))->inverse() * *trajectory.at(at(to))};
}

TEST(RelationsError, OfTrueRelationsIsZero) {
  const Trajectory trajectory = path();
  const RelationsError error = relations_error(
      trajectory, {true_relation(trajectory, 0, 5), true_relation(trajectory, 12, 3),
                   true_relation(trajectory, 2.5, 7.25)});
  EXPECT_EQ(error.pairs, 3);
  EXPECT_EQ(error.pairs_interpolated, 1);
  EXPECT_LT(error.translation_m.max, 1e-9);
  EXPECT_LT(error.rotation_rad.max, 1e-9);
}

TEST(RelationsError, DependsOnTheOrderOfTheProductInTranslationOnly) {
  const Trajectory trajectory = path();
  Relation relation = true_relation(trajectory, 3, 9);
  const Pose2 measured = relation.from_T_to;
  relation.from_T_to = Pose2{measured.x + 0.1, measured.y, measured.yaw + 0.3};
  const Pose2 expected = relation.from_T_to;
  const RelationsError cartographer = relations_error(trajectory, {relation});
  const RelationsError swapped =
      relations_error(trajectory, {relation}, RelationErrorOrder::kInverseExpectedTimesMeasured);
  EXPECT_NEAR(cartographer.translation_m.mean, (measured * expected.inverse()).translation().norm(),
              1e-12);
  EXPECT_NEAR(swapped.translation_m.mean, 0.1, 1e-12)
      << "as seen from the true pose the error is what was put in";
  EXPECT_GT(std::abs(cartographer.translation_m.mean - swapped.translation_m.mean), 0.1);
  EXPECT_NEAR(cartographer.rotation_rad.mean, 0.3, 1e-12);
  EXPECT_NEAR(swapped.rotation_rad.mean, 0.3, 1e-12);
  EXPECT_NEAR(cartographer.squared_rotation_deg2.mean, std::pow(degrees(0.3), 2), 1e-9);
  EXPECT_NEAR(cartographer.squared_translation_m2.mean,
              std::pow(cartographer.translation_m.mean, 2), 1e-12);
}

TEST(RelationsError, TakesThePoseWithTheVeryStamp) {
  Trajectory jumpy;
  jumpy.append(at(0.0), {});
  jumpy.append(at(1.0), {1.0, 0.0, 0.0});
  jumpy.append(at(1.001), {500.0, 0.0, 0.0});
  // 50 us after the pose at 1 s: interpolated it would lie 25 m away.
  const RelationsError error =
      relations_error(jumpy, {{at(0.0), at(1.0) + Duration{50'000}, {1.0, 0.0, 0.0}}});
  EXPECT_EQ(error.pairs_interpolated, 0);
  EXPECT_LT(error.translation_m.max, 1e-12);
}

TEST(RelationsError, CountsRelationsOutsideTheTimeAsMissing) {
  const Trajectory trajectory = path();
  const RelationsError error = relations_error(
      trajectory,
      {{at(-1.0), at(2.0), {}}, {at(2.0), at(19.5), {}}, true_relation(trajectory, 1, 2)});
  EXPECT_EQ(error.pairs, 1);
  ASSERT_EQ(error.missing.size(), 2u);
  EXPECT_EQ(error.missing[0].from, at(-1.0));
  EXPECT_LT(error.translation_m.max, 1e-9) << "clamped ends would show as an error";
}

}  // namespace
}  // namespace loopstone
