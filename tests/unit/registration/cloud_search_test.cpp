#include "loopstone/registration/cloud_search.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "cloud_search_shapes.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/rigid_alignment.hpp"
#include "loopstone/sensor/point_cloud.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::moved;
using test::pose_near;
using test::random_motion;
using test::sample_surface;

template <int kDimension>
using Points = std::vector<Eigen::Matrix<double, kDimension, 1>>;

constexpr double kToolNoiseM = 0.001;
constexpr double kOutlineNoiseM = 0.01;

const CloudModel<3>& tool_model() {
  static const CloudModel<3> model = [] {
    Rng rng(1);
    return CloudModel<3>(sample_surface<3>(test::tool(), 3000, 0.0, Eigen::Vector3d::Zero(), rng));
  }();
  return model;
}

const CloudModel<2>& outline_model() {
  static const CloudModel<2> model = [] {
    Rng rng(2);
    return CloudModel<2>(
        sample_surface<2>(test::outline(), 800, 0.0, Eigen::Vector2d::Zero(), rng));
  }();
  return model;
}

/// The tool, as seen from one side.
Points<3> tool_seen_from(const Eigen::Vector3d& viewer, std::size_t count, Rng& rng) {
  return sample_surface<3>(test::tool(), count, kToolNoiseM, viewer, rng);
}

/// What is left between two answers, in the frame of the model: the source's origin may lie metres
/// away, where a small turn is a long way.
Pose3 difference(const Pose3& a, const Pose3& b) { return a * b.inverse(); }

TEST(CloudSearch, FindsAPartSeenFromOneSideHoweverItIsTurned) {
  Rng rng(3);
  for (int trial = 0; trial < 8; ++trial) {
    // From above and from the sides; from below too much is hidden by the battery.
    const double height = rng.uniform(-0.3, 1.0);
    const Eigen::Vector3d viewer(rng.normal(), trial % 2 == 0 ? 1.0 : -1.0, height);
    const Pose3 object_T_camera = random_motion(rng, Pose3{});
    const auto source = moved(object_T_camera.inverse(), tool_seen_from(viewer, 700, rng));
    const auto result = search_alignment<3>(source, tool_model());
    EXPECT_EQ(result.match.status, MatchStatus::kConverged) << trial;
    EXPECT_FALSE(result.ambiguous) << trial;
    EXPECT_TRUE(
        pose_near(difference(result.match.target_T_source, object_T_camera), Pose3{}, 0.003, 0.03))
        << trial;
    EXPECT_LT(result.match.rmse_m, 0.004);
    EXPECT_GT(result.match.score, 0.97);
    EXPECT_GE(result.agreeing, 1);
  }
}

TEST(CloudSearch, FindsAPartInThePlane) {
  Rng rng(4);
  for (int trial = 0; trial < 8; ++trial) {
    const Pose2 object_T_sensor = random_motion(rng, Pose2{});
    const auto source = moved(object_T_sensor.inverse(),
                              sample_surface<2>(test::outline(), 200, kOutlineNoiseM,
                                                Eigen::Vector2d(0.6 * rng.normal(), 1.0), rng));
    const auto result = search_alignment<2>(source, outline_model());
    EXPECT_EQ(result.match.status, MatchStatus::kConverged) << trial;
    EXPECT_TRUE(
        pose_near(result.match.target_T_source * object_T_sensor.inverse(), Pose2{}, 0.03, 0.02))
        << trial;
  }
}

TEST(CloudSearch, TheAnswerMovesWithTheClouds) {
  Rng rng(5);
  const auto model = sample_surface<3>(test::tool(), 1500, 0.0, Eigen::Vector3d::Zero(), rng);
  const auto source = tool_seen_from({0.3, 1.0, 0.4}, 500, rng);
  const Pose3 before = search_alignment<3>(source, CloudModel<3>(model)).match.target_T_source;
  const Pose3 a = random_motion(rng, Pose3{});
  const Pose3 b = random_motion(rng, Pose3{});
  const auto after = search_alignment<3>(moved(b, source), CloudModel<3>(moved(a, model))).match;
  EXPECT_TRUE(
      pose_near(difference(after.target_T_source, a * before * b.inverse()), Pose3{}, 1e-3, 5e-3));
}

TEST(CloudSearch, TheOrderOfPointsIsOfNoMatter) {
  Rng rng(6);
  auto source = tool_seen_from({-0.3, 1.0, 0.4}, 2600, rng);
  const auto before = search_alignment<3>(source, tool_model()).match;
  for (std::size_t i = source.size(); i > 1; --i) std::swap(source[i - 1], source[rng.below(i)]);
  const auto after = search_alignment<3>(source, tool_model()).match;
  EXPECT_TRUE(
      pose_near(difference(after.target_T_source, before.target_T_source), Pose3{}, 1e-3, 5e-3));
  EXPECT_NEAR(after.rmse_m, before.rmse_m, 1e-6);
}

TEST(CloudSearch, ACloudLiesOnItself) {
  Rng rng(7);
  const auto cloud = sample_surface<3>(test::tool(), 1000, 0.0, Eigen::Vector3d::Zero(), rng);
  const auto result = search_alignment<3>(cloud, CloudModel<3>(cloud));
  EXPECT_TRUE(pose_near(result.match.target_T_source, Pose3{}, 1e-6, 1e-5));
  EXPECT_LT(result.match.rmse_m, 1e-6);
  EXPECT_EQ(result.match.pairs, 1000);
  EXPECT_EQ(result.match.status, MatchStatus::kConverged);
}

TEST(CloudSearch, AStepOfIteratedClosestPointsGainsNothingMore) {
  Rng rng(8);
  const auto model = sample_surface<2>(test::outline(), 800, 0.0, Eigen::Vector2d::Zero(), rng);
  const auto source =
      sample_surface<2>(test::outline(), 300, kOutlineNoiseM, Eigen::Vector2d(0.2, 1.0), rng);
  const auto found = search_alignment<2>(source, CloudModel<2>(model)).match;
  const auto nearest = [&](const Eigen::Vector2d& query) {
    return *std::min_element(model.begin(), model.end(), [&](const auto& a, const auto& b) {
      return (a - query).squaredNorm() < (b - query).squaredNorm();
    });
  };
  const auto rmse_at = [&](const Pose2& pose) {
    double sum = 0.0;
    for (const auto& p : source) sum += (pose * p - nearest(pose * p)).squaredNorm();
    return std::sqrt(sum / static_cast<double>(source.size()));
  };
  Points<2> partners;
  for (const auto& p : source) partners.push_back(nearest(found.target_T_source * p));
  const Pose2 stepped = to_pose(align_rigidly<2>(source, partners));
  EXPECT_NEAR(rmse_at(found.target_T_source), found.rmse_m, 1e-6);
  EXPECT_GT(rmse_at(stepped), (1.0 - 2e-4) * found.rmse_m);
}

TEST(CloudSearch, ASymmetricShapeIsAmbiguousAndSaysHowMuch) {
  Rng rng(9);
  const auto shape = test::box({-0.1, -0.05, -0.05}, {0.1, 0.05, 0.05});
  const CloudModel<3> model(sample_surface<3>(shape, 2500, 0.0, Eigen::Vector3d::Zero(), rng));
  const auto source = sample_surface<3>(shape, 600, 0.001, Eigen::Vector3d(0.5, 0.6, 0.7), rng);
  const auto result = search_alignment<3>(source, model);
  EXPECT_TRUE(result.ambiguous);
  EXPECT_EQ(result.match.status, MatchStatus::kDegenerate);
  ASSERT_TRUE(result.runner_up.has_value());
  EXPECT_LT(result.runner_up->rmse_m, 1.1 * result.best_sampled_rmse_m);
  // Either pose may be true: the covariance holds the rival within about one and a half standard
  // deviations.
  const Tangent3 apart =
      RigidMotion<3>::difference(result.runner_up->target_T_source, result.match.target_T_source);
  const double squared_distance = apart.dot(result.match.covariance.inverse() * apart);
  EXPECT_LT(squared_distance, 2.1);
  EXPECT_GT(squared_distance, 1.0);
}

TEST(CloudSearch, IsTheSameToTheBitWithAnyNumberOfThreads) {
  Rng rng(10);
  const auto source = tool_seen_from({0.4, -1.0, 0.4}, 500, rng);
  const auto one = search_alignment<3>(source, tool_model(), {}, Threads{1});
  const auto four = search_alignment<3>(source, tool_model(), {}, Threads{4});
  EXPECT_EQ(one.match.target_T_source.translation, four.match.target_T_source.translation);
  EXPECT_EQ(one.match.target_T_source.rotation.coeffs(),
            four.match.target_T_source.rotation.coeffs());
  EXPECT_EQ(one.match.covariance, four.match.covariance);
  EXPECT_EQ(one.agreeing, four.agreeing);
}

TEST(CloudSearch, LeavesOutWhatTheModelDoesNotHold) {
  Rng rng(11);
  const Pose3 object_T_camera = random_motion(rng, Pose3{});
  auto source = tool_seen_from({0.3, 1.0, 0.5}, 700, rng);
  // A thing beside it, as densely seen.
  const auto beside = sample_surface<3>(test::box({0.15, -0.05, -0.1}, {0.2, 0.05, 0.0}), 140,
                                        kToolNoiseM, Eigen::Vector3d(0.3, 1.0, 0.5), rng);
  source.insert(source.end(), beside.begin(), beside.end());
  CloudSearchOptions options;
  options.overlap = 0.7;
  const auto result =
      search_alignment<3>(moved(object_T_camera.inverse(), source), tool_model(), options);
  EXPECT_TRUE(
      pose_near(difference(result.match.target_T_source, object_T_camera), Pose3{}, 0.003, 0.03));
  EXPECT_NEAR(result.match.inlier_fraction, 0.7, 0.01);
}

TEST(CloudSearch, TurnsAboutZAloneWhenAsked) {
  Rng rng(12);
  CloudSearchOptions options;
  options.turns = SearchTurns::kAboutZ;
  options.starts = 24;
  for (const double yaw : {-2.0, 0.5, 3.0}) {
    const Pose3 object_T_camera = Pose3::from_roll_pitch_yaw({0.5, -0.3, 0.2}, 0.0, 0.0, yaw);
    const auto source = moved(object_T_camera.inverse(), tool_seen_from({0.2, 1.0, 0.6}, 500, rng));
    const auto result = search_alignment<3>(source, tool_model(), options);
    EXPECT_EQ(result.starts, 2 * 24);
    EXPECT_TRUE(
        pose_near(difference(result.match.target_T_source, object_T_camera), Pose3{}, 0.003, 0.03));
  }
}

TEST(CloudSearch, SaysWhenNothingFits) {
  Rng rng(13);
  Points<3> source;  // a hollow ball as large as the tool
  for (int i = 0; i < 500; ++i) source.push_back(0.25 * test::random_direction<3>(rng));
  const auto result = search_alignment<3>(source, tool_model());
  EXPECT_EQ(result.match.status, MatchStatus::kNotConverged);
  EXPECT_LT(result.match.score, 0.5);
}

TEST(CloudSearch, TooFewPointsAreTooFew) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Points<3> source{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {nan, 0.0, 0.0}};
  EXPECT_EQ(search_alignment<3>(source, tool_model()).match.status, MatchStatus::kTooFewPairs);
  EXPECT_EQ(search_alignment<3>({}, tool_model()).match.status, MatchStatus::kTooFewPairs);
  EXPECT_THROW((void)CloudModel<3>(source), DataError);
}

TEST(CloudSearch, PointsThatAreNotFiniteAreIgnored) {
  Rng rng(14);
  auto source = tool_seen_from({0.3, 1.0, 0.5}, 400, rng);
  const auto clean = search_alignment<3>(source, tool_model()).match;
  source.insert(source.begin() + 100,
                Eigen::Vector3d(std::numeric_limits<double>::infinity(), 0.0, 0.0));
  const auto dirty = search_alignment<3>(source, tool_model()).match;
  EXPECT_EQ(clean.target_T_source.translation, dirty.target_T_source.translation);
  EXPECT_EQ(clean.pairs, dirty.pairs);
}

TEST(CloudSearch, PointsThatAreNowhereAreIgnored) {
  Rng rng(15);
  auto source = tool_seen_from({0.3, 1.0, 0.5}, 400, rng);
  const auto clean = search_alignment<3>(source, tool_model()).match;
  for (const double far : {3.4e38, 1e100, -1e300}) source.emplace_back(0.0, far, 0.0);
  const auto dirty = search_alignment<3>(source, tool_model()).match;
  EXPECT_EQ(clean.target_T_source.translation, dirty.target_T_source.translation);
  Points<3> model = source;
  EXPECT_NO_THROW((void)CloudModel<3>(model)) << "once this never ended";
}

TEST(CloudSearch, EndsForAnyCoordinatesThatArePlaces) {
  Rng rng(16);
  const auto tool = tool_seen_from({0.3, 1.0, 0.5}, 300, rng);
  for (const double far : {kFarthestCoordinateM, 1e6, 1e-30, 1e-300}) {
    Points<3> one = tool;
    one.emplace_back(far, -far, far);
    Points<3> all = tool;
    for (Eigen::Vector3d& point : all) point *= far;
    for (const Points<3>& cloud : {one, all}) {
      const auto match = search_alignment<3>(cloud, CloudModel<3>(cloud)).match;
      EXPECT_TRUE(match.target_T_source.translation.allFinite()) << far;
    }
  }
}

TEST(CloudSearch, SurvivesDegenerateClouds) {
  // All points in one place, on one line, in one plane: an answer with a status, and no NaN.
  Points<3> place(50, Eigen::Vector3d(1.0, 2.0, 3.0));
  Points<3> line;
  Points<3> plane;
  for (int i = 0; i < 50; ++i) {
    line.emplace_back(0.01 * i, 0.0, 0.0);
    plane.emplace_back(0.01 * (i % 7), 0.01 * (i / 7), 0.0);
  }
  for (const Points<3>& source : {place, line, plane}) {
    for (const Points<3>& target : {place, line, plane}) {
      const auto match = search_alignment<3>(source, CloudModel<3>(target)).match;
      EXPECT_TRUE(match.target_T_source.translation.allFinite());
      EXPECT_TRUE(match.target_T_source.rotation.coeffs().allFinite());
      EXPECT_TRUE(match.covariance.allFinite());
      EXPECT_NE(match.status, MatchStatus::kConverged);
    }
  }
}

}  // namespace
}  // namespace loopstone
