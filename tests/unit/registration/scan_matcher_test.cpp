#include "loopstone/registration/scan_matcher.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "registration/scan_fit.hpp"
#include "registration/window_search.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using test::Scanner;
using test::Walls;

const Scanner kWideScanner{.angle_min_rad = radians(-135.0),
                           .angle_increment_rad = radians(0.25),
                           .beams = 1081,
                           .noise_m = 0.01};
const Scanner kNarrowScanner{.angle_min_rad = radians(-89.5),
                             .angle_increment_rad = radians(1.0),
                             .beams = 180,
                             .noise_m = 0.01};

ScanView view_from(const Walls& walls, const Pose2& world_T_robot, const Scanner& scanner, Rng* rng,
                   const Pose2& robot_T_lidar = {}) {
  BeamTable beams;
  return view_scan(test::scan_from(walls, world_T_robot, robot_T_lidar, scanner, rng),
                   robot_T_lidar, Tangent2::Zero(), beams);
}

Scanner without_noise(Scanner scanner) {
  scanner.noise_m = 0.0;
  return scanner;
}

struct Trial {
  ScanView target;
  ScanView source;
  Pose2 target_T_source;
};

/// Two places in the furnished room, the second at most `reach_m` and `turn_rad` away, both with
/// room around them.
Trial random_trial(Rng& rng, const Scanner& scanner, double reach_m, double turn_rad) {
  const Walls room = test::furnished_room();
  while (true) {
    const Pose2 target{rng.uniform(0.6, 7.4), rng.uniform(0.6, 5.4), rng.uniform(-3.1, 3.1)};
    const double bearing = rng.uniform(-3.1, 3.1);
    const double distance = reach_m * std::sqrt(rng.uniform());
    const Pose2 motion{distance * std::cos(bearing), distance * std::sin(bearing),
                       rng.uniform(-turn_rad, turn_rad)};
    const Pose2 source = target * motion;
    const Eigen::Vector2d way = source.translation() - target.translation();
    if (test::distance_to_walls(room, target.translation()) < 0.4 ||
        test::distance_to_walls(room, source.translation()) < 0.4 || source.x < 0.0 ||
        source.x > 8.0 || source.y < 0.0 || source.y > 6.0 ||
        (way.norm() > 1e-6 &&
         test::cast_ray(room, target.translation(), way.normalized()) < way.norm()))
      continue;
    return {view_from(room, target, scanner, &rng), view_from(room, source, scanner, &rng), motion};
  }
}

TEST(ScanMatcher, FindsAPoseThatIsFarFromTheGuess) {
  for (const Scanner& scanner : {kWideScanner, kNarrowScanner}) {
    Rng rng(5);
    int observable = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const Trial pair = random_trial(rng, scanner, 0.8, radians(45.0));
      const MatchResult match = match_scans(pair.source, pair.target, {});
      if (match.status == MatchStatus::kDegenerate) continue;
      ++observable;
      EXPECT_EQ(match.status, MatchStatus::kConverged) << trial;
      EXPECT_TRUE(pose_near(match.target_T_source, pair.target_T_source, 0.02, radians(0.3)))
          << trial;
    }
    EXPECT_GE(observable, 55);
  }
}

TEST(ScanMatcher, AScanMatchesItself) {
  const ScanView view =
      view_from(test::furnished_room(), {3.0, 2.0, 0.4}, without_noise(kWideScanner), nullptr);
  const MatchResult match = match_scans(view, view, {0.3, -0.2, 0.3});
  EXPECT_EQ(match.status, MatchStatus::kConverged);
  EXPECT_TRUE(pose_near(match.target_T_source, Pose2{}, 1e-4, 1e-5));
  EXPECT_GT(match.score, 0.99);
}

TEST(ScanMatcher, GivesTheInverseWhenSourceAndTargetChangePlaces) {
  Rng rng(6);
  for (int trial = 0; trial < 10; ++trial) {
    const Trial pair = random_trial(rng, kWideScanner, 0.5, radians(20.0));
    const MatchResult there = match_scans(pair.source, pair.target, {});
    const MatchResult back = match_scans(pair.target, pair.source, {});
    EXPECT_TRUE(pose_near(back.target_T_source.inverse(), there.target_T_source, 0.003, 0.001));
  }
}

TEST(ScanMatcher, TurnsAndMovesWithItsFrames) {
  // The same two scans, the lidars mounted differently on the robots.
  const Pose2 target_mount{0.3, -0.1, 0.7};
  const Pose2 source_mount{-0.2, 0.15, -0.4};
  const Walls room = test::furnished_room();
  const Pose2 world_T_target{3.0, 2.0, 0.4};
  const Pose2 world_T_source{3.3, 2.2, 0.6};
  const Scanner scanner = without_noise(kWideScanner);
  const MatchResult plain = match_scans(view_from(room, world_T_source, scanner, nullptr),
                                        view_from(room, world_T_target, scanner, nullptr), {});
  const auto mounted = [&](const Pose2& world_T_lidar, const Pose2& mount) {
    return view_from(room, world_T_lidar * mount.inverse(), scanner, nullptr, mount);
  };
  const Pose2 guess = target_mount * source_mount.inverse();
  const MatchResult other = match_scans(mounted(world_T_source, source_mount),
                                        mounted(world_T_target, target_mount), guess);
  EXPECT_TRUE(pose_near(other.target_T_source,
                        target_mount * plain.target_T_source * source_mount.inverse(), 2e-4, 1e-4));
}

TEST(ScanMatcher, WithoutSearchStaysNearAGoodGuess) {
  Rng rng(7);
  const ScanMatchOptions options{.search_half_xy_m = 0.0, .search_half_yaw_rad = 0.0};
  for (int trial = 0; trial < 20; ++trial) {
    const Trial pair = random_trial(rng, kWideScanner, 0.5, radians(20.0));
    const Pose2 guess = pair.target_T_source * Pose2{0.03, -0.02, radians(1.0)};
    const MatchResult match = match_scans(pair.source, pair.target, guess, options);
    EXPECT_TRUE(pose_near(match.target_T_source, pair.target_T_source, 0.01, radians(0.1)));
  }
}

TEST(ScanMatcher, ItsCovarianceIsHonest) {
  Rng rng(8);
  double sum = 0.0;
  int count = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const Trial pair =
        random_trial(rng, trial % 2 == 0 ? kWideScanner : kNarrowScanner, 0.3, radians(20.0));
    const MatchResult match = match_scans(pair.source, pair.target, {});
    if (match.status != MatchStatus::kConverged) continue;
    const Eigen::Vector3d error =
        RigidMotion<2>::difference(match.target_T_source, pair.target_T_source);
    sum += error.dot(match.covariance.inverse() * error);
    ++count;
  }
  ASSERT_GT(count, 130);
  EXPECT_GT(sum / count, 2.0);  // 3 is perfect
  EXPECT_LT(sum / count, 5.0);
}

TEST(ScanMatcher, InACorridorTheGuessStandsAlongIt) {
  const Walls corridor{{{-50.0, 0.0}, {50.0, 0.0}}, {{-50.0, 2.0}, {50.0, 2.0}}};
  Rng rng(9);
  Scanner scanner = kWideScanner;
  scanner.range_max_m = 15.0;
  const ScanView target = view_from(corridor, {0.0, 1.0, 0.1}, scanner, &rng);
  const ScanView source = view_from(corridor, {0.4, 1.1, 0.0}, scanner, &rng);
  const Pose2 guess{0.2, 0.0, 0.0};
  const MatchResult match = match_scans(source, target, guess);
  EXPECT_EQ(match.status, MatchStatus::kDegenerate);
  // Across and turn are found; along, on the target's axes (cos 0.1, -sin 0.1), it stays where it
  // was.
  const Eigen::Vector2d along(std::cos(0.1), -std::sin(0.1));
  const Eigen::Vector2d across(std::sin(0.1), std::cos(0.1));
  const Pose2 truth = Pose2{0.0, 1.0, 0.1}.inverse() * Pose2{0.4, 1.1, 0.0};
  EXPECT_NEAR(along.dot(match.target_T_source.translation() - guess.translation()), 0.0, 0.02);
  EXPECT_NEAR(across.dot(match.target_T_source.translation() - truth.translation()), 0.0, 0.01);
  EXPECT_NEAR(wrap_angle(match.target_T_source.yaw - truth.yaw), 0.0, 0.002);
  const Eigen::Matrix2d covariance = match.covariance.topLeftCorner<2, 2>();
  EXPECT_GT(along.dot(covariance * along), 1.0);
  EXPECT_LT(across.dot(covariance * across), 1e-4);
}

TEST(ScanMatcher, InsideACircleTheHeadingIsOpen) {
  Walls circle;
  for (int i = 0; i < 360; ++i) {
    const auto corner = [](int k) {
      return Eigen::Vector2d(4.0 * std::cos(radians(k)), 4.0 * std::sin(radians(k)));
    };
    circle.push_back({corner(i), corner(i + 1)});
  }
  Scanner all_round{.angle_min_rad = -kPi, .angle_increment_rad = radians(0.5), .beams = 720};
  const ScanView target = view_from(circle, {}, all_round, nullptr);
  const ScanView source = view_from(circle, {0.2, 0.1, 0.3}, all_round, nullptr);
  const MatchResult match = match_scans(source, target, {0.1, 0.1, 0.1});
  EXPECT_EQ(match.status, MatchStatus::kDegenerate);
  EXPECT_GT(match.covariance(2, 2), 0.1);
}

TEST(ScanMatcher, SaysSoWhenThereIsTooLittle) {
  const ScanView room =
      view_from(test::furnished_room(), {3.0, 2.0, 0.4}, without_noise(kWideScanner), nullptr);
  const ScanView nothing = view_from({}, {}, without_noise(kWideScanner), nullptr);
  const Pose2 guess{0.1, 0.2, 0.3};
  for (const MatchResult& match :
       {match_scans(nothing, room, guess), match_scans(room, nothing, guess),
        match_scans(nothing, nothing, guess)}) {
    EXPECT_EQ(match.status, MatchStatus::kTooFewPairs);
    EXPECT_EQ(match.target_T_source, guess);
    EXPECT_GT(match.covariance(0, 0), 1.0);
  }
}

TEST(ScanMatcher, ScansOfOtherPlacesRarelyConverge) {
  // A long thin room cannot be the furnished one.
  Rng rng(10);
  const Walls other =
      test::together({test::rectangle({0.0, 0.0}, {3.0, 14.0}),
                      test::moved({1.0, 5.0, 0.5}, test::rectangle({0.0, 0.0}, {0.5, 1.0}))});
  int converged = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const Trial pair = random_trial(rng, kWideScanner, 0.5, 0.5);
    const ScanView elsewhere =
        view_from(other, {1.5, rng.uniform(1.0, 3.5), rng.uniform(-3.1, 3.1)}, kWideScanner, &rng);
    converged += match_scans(elsewhere, pair.target, {}).status == MatchStatus::kConverged ? 1 : 0;
  }
  EXPECT_LE(converged, 2);
}

TEST(WindowSearch, ListsDistinctPosesBestFirstAndTheTruthAmongThem) {
  Rng rng(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Trial pair = random_trial(rng, kWideScanner, 0.8, radians(45.0));
    const auto candidates = search_window(pair.source, pair.target, {}, 1.0, radians(50.0), 6);
    ASSERT_FALSE(candidates.empty());
    bool truth_found = false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Pose2 error = pair.target_T_source.inverse() * candidates[i].target_T_source;
      truth_found |= std::hypot(error.x, error.y) < 0.3 && std::abs(error.yaw) < radians(6.0);
      if (i > 0) {
        EXPECT_LE(candidates[i].score, candidates[i - 1].score);
        EXPECT_NE(candidates[i].target_T_source, candidates[i - 1].target_T_source);
      }
    }
    EXPECT_TRUE(truth_found) << trial;
  }
}

TEST(ScanFit, AgreementIsTheWholeSource) {
  Rng rng(12);
  const Trial pair = random_trial(rng, kWideScanner, 0.8, radians(45.0));
  double weight = 0.0;
  for (const SurfacePoint& surface : pair.source.surfaces) weight += surface.weight;
  const ScanEquations equations =
      scan_equations(pair.source, pair.target, pair.target_T_source, {1, 0.03});
  EXPECT_NEAR(equations.agreement.total(), weight, 1e-6);
  EXPECT_GT(equations.agreement.explained, 0.5 * weight);
}

TEST(ScanFit, GradientVanishesAtTheTruthAndOneStepLeadsThere) {
  const Walls room = test::rectangle({0.0, 0.0}, {7.0, 5.0});  // straight walls: lines are exact
  const Pose2 world_T_target{3.0, 2.0, 0.4};
  const Pose2 world_T_source{3.2, 2.1, 0.5};
  const Scanner scanner = without_noise(kWideScanner);
  const ScanView target = view_from(room, world_T_target, scanner, nullptr);
  const ScanView source = view_from(room, world_T_source, scanner, nullptr);
  const Pose2 truth = world_T_target.inverse() * world_T_source;
  const ScanEquations there = scan_equations(source, target, truth, {1, 1.0});
  EXPECT_LT(there.gradient.norm(), 0.02 * std::sqrt(there.hessian.norm()));
  const Pose2 near = RigidMotion<2>::moved(truth, {0.004, -0.003, 0.002});
  const ScanEquations equations = scan_equations(source, target, near, {1, 1.0});
  const Eigen::Vector3d step = -equations.hessian.inverse() * equations.gradient;
  EXPECT_TRUE(pose_near(RigidMotion<2>::moved(near, step), truth, 3e-4, 1e-4));
}

}  // namespace
}  // namespace loopstone
