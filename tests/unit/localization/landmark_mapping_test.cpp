#include "loopstone/localization/landmark_mapping.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "landmark_scene.hpp"
#include "localization/landmark_group.hpp"
#include "localization/landmark_tracks.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/localization/reflector_mapping.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone::test {
namespace {

constexpr double kStepSigmaM = 0.01;
constexpr double kStepSigmaRad = 0.003;

/// A robot that drives round in the hall of landmark_scene.hpp, and what it saw.
struct Round {
  std::vector<Pose2> truth{};
  PoseGraph graph{};  ///< from odometry, which drifts
  std::vector<std::vector<LandmarkObservation>> seen{};
};

struct RoundOptions {
  int steps = 120;
  bool names = false;
  double noise = 1.0;
  double range_m = 7.0;
};

Round drive_round(const RoundOptions& options, std::uint64_t seed) {
  Rng rng(seed);
  Round round;
  const LandmarkMap map = hall_map();
  const Pose2 step{0.4, 0.0, 0.4 / 5.0};
  Pose2 truth{};
  for (int i = 0; i < options.steps; ++i) {
    if (i > 0) {
      truth = truth * step;
      const Pose2 told = step * Pose2{options.noise * rng.normal(0.0, kStepSigmaM),
                                      options.noise * rng.normal(0.0, kStepSigmaM),
                                      options.noise * rng.normal(0.0, kStepSigmaRad)};
      round.graph.poses.push_back(round.graph.poses.back() * told);
      round.graph.edges.push_back(edge_between(
          i - 1, i, {told, planar_covariance(kStepSigmaM, kStepSigmaRad)}, EdgeKind::kOdometry));
    } else {
      round.graph.poses.emplace_back();
    }
    round.truth.push_back(truth);
    round.seen.push_back(seen_from(truth, map, in_range(truth, map, options.range_m), options.names,
                                   rng, options.noise));
  }
  return round;
}

/// Largest distance to the nearest true landmark; the first pose is the true one.
double farthest_off(const LandmarkMapping& mapping) {
  const LandmarkMap map = hall_map();
  double largest = 0.0;
  for (const FoundLandmark& found : mapping.landmarks) {
    double nearest = 100.0;
    for (const MappedLandmark& landmark : map.landmarks())
      nearest = std::min(nearest, (found.position - landmark.position).norm());
    largest = std::max(largest, nearest);
  }
  return largest;
}

std::size_t landmarks_in_view(const Round& round, double range_m, int least) {
  const LandmarkMap map = hall_map();
  std::vector<int> counts(map.size(), 0);
  for (const Pose2& pose : round.truth) {
    for (const std::size_t i : in_range(pose, map, range_m)) ++counts[i];
  }
  return static_cast<std::size_t>(
      std::ranges::count_if(counts, [&](int count) { return count >= least; }));
}

TEST(MapLandmarks, NamedOnesAreWhereTheyAre) {
  const Round round = drive_round({.names = true}, 1);
  const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, {});
  EXPECT_EQ(mapping.landmarks.size(), landmarks_in_view(round, 7.0, 4));
  const LandmarkMap map = hall_map();
  for (const FoundLandmark& found : mapping.landmarks) {
    const MappedLandmark& truth = map[*map.index_of(found.id)];
    const Eigen::Vector2d off = found.position - truth.position;
    EXPECT_LT(off.norm(), 0.08) << found.id;
    EXPECT_LT(off.dot(found.covariance.inverse() * off), 14.0) << found.id;
  }
}

TEST(MapLandmarks, NamelessOnesAreFoundOnceEach) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Round round = drive_round({}, seed);
    const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, {});
    EXPECT_EQ(mapping.landmarks.size(), landmarks_in_view(round, 7.0, 4)) << seed;
    EXPECT_LT(farthest_off(mapping), 0.1) << seed;
    // They close the loop: odometry alone is some tenths of a metre off.
    const Pose2 off = mapping.graph.poses.back().inverse() * round.truth.back();
    EXPECT_LT(off.translation().norm(), 0.1) << seed;
  }
}

TEST(MapLandmarks, TheSameEachTime) {
  const Round round = drive_round({}, 5);
  const LandmarkMapping one = map_landmarks(round.graph, round.seen, {});
  const LandmarkMapping other = map_landmarks(round.graph, round.seen, {});
  EXPECT_EQ(one.graph.poses, other.graph.poses);
  EXPECT_EQ(one.graph.landmarks, other.graph.landmarks);
}

TEST(MapLandmarks, ClutterBecomesNone) {
  Round round = drive_round({}, 7);
  Rng rng(8);
  for (std::vector<LandmarkObservation>& reading : round.seen) {
    if (rng.uniform() < 0.5) {
      reading.push_back(observed(rng.uniform(1.0, 7.0), rng.uniform(-kPi, kPi), kSceneRangeSigmaM,
                                 kSceneBearingSigmaRad));
    }
  }
  const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, {});
  EXPECT_EQ(mapping.landmarks.size(), landmarks_in_view(round, 7.0, 4));
  EXPECT_LT(farthest_off(mapping), 0.1);
}

TEST(MapLandmarks, WhatMovesBecomesNone) {
  Round round = drive_round({}, 9);
  Rng rng(10);
  for (std::size_t i = 20; i < 60; ++i) {
    // A quarter of the robot's own speed.
    const Eigen::Vector2d at =
        round.truth[i].inverse() * Eigen::Vector2d(-2.0 + 0.1 * static_cast<double>(i - 20), 6.0);
    round.seen[i].push_back(observed(at.norm() + rng.normal(0.0, kSceneRangeSigmaM),
                                     std::atan2(at.y(), at.x()), kSceneRangeSigmaM,
                                     kSceneBearingSigmaRad));
  }
  const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, {});
  EXPECT_LT(farthest_off(mapping), 0.1) << "it is not among them";
  EXPECT_EQ(mapping.landmarks.size(), landmarks_in_view(round, 7.0, 4));
}

TEST(MapLandmarks, WhatIsSeenFromOnePlaceOnlyBecomesNone) {
  PoseGraph graph;
  std::vector<std::vector<LandmarkObservation>> seen;
  for (int i = 0; i < 20; ++i) {
    graph.poses.emplace_back();
    if (i > 0)
      graph.edges.push_back(
          edge_between(i - 1, i, {{}, planar_covariance(0.01, 0.01)}, EdgeKind::kOdometry));
    seen.push_back({observed(3.0, 0.1, 0.02, 0.004)});
  }
  const LandmarkMapping mapping = map_landmarks(graph, seen, {});
  EXPECT_TRUE(mapping.landmarks.empty());
  EXPECT_EQ(mapping.figures.too_few, 1);
  EXPECT_TRUE(mapping.graph.landmark_edges.empty());
}

TEST(MapLandmarks, WhatIsSeenThroughBecomesNone) {
  const Round round = drive_round({.names = true}, 11);
  const LandmarkMap map = hall_map();
  const auto through = [&](std::size_t node, const Eigen::Vector2d& point) {
    const Eigen::Vector2d at = round.truth[node] * point;
    return std::optional<bool>((at - map[1].position).norm() < 0.3);
  };
  const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, {}, through);
  EXPECT_EQ(mapping.figures.see_through, 1);
  for (const FoundLandmark& found : mapping.landmarks) EXPECT_NE(found.id, map[1].id);
}

/// The textbook's filter, everything dense: pose first, then landmarks as they come.
class EkfSlam {
 public:
  void move(const Pose2& motion, const Eigen::Matrix3d& covariance) {
    const Eigen::Matrix3d by_pose = compose_jacobian_left(pose_, motion);
    const Eigen::Matrix3d by_motion = compose_jacobian_right(pose_, motion);
    const auto rest = p_.rows() - 3;
    p_.topLeftCorner<3, 3>() = (by_pose * p_.topLeftCorner<3, 3>() * by_pose.transpose() +
                                by_motion * covariance * by_motion.transpose())
                                   .eval();
    p_.topRightCorner(3, rest) = (by_pose * p_.topRightCorner(3, rest)).eval();
    p_.bottomLeftCorner(rest, 3) = p_.topRightCorner(3, rest).transpose();
    pose_ = pose_ * motion;
  }
  void see(const LandmarkObservation& seen) {
    const auto known = std::ranges::find(ids, *seen.id);
    if (known == ids.end()) {
      add(seen);
      return;
    }
    const auto k = static_cast<std::size_t>(known - ids.begin());
    const LandmarkJacobians j = landmark_jacobians(pose_, landmarks[k]);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2, p_.rows());
    h.leftCols<3>() = j.from;
    h.middleCols<2>(3 + 2 * static_cast<Eigen::Index>(k)) = j.landmark;
    const Eigen::Matrix2d s = h * p_ * h.transpose() + seen.covariance;
    const Eigen::MatrixXd gain = p_ * h.transpose() * s.inverse();
    const Eigen::VectorXd step = gain * (seen.point - pose_.inverse() * landmarks[k]);
    pose_ = {pose_.x + step(0), pose_.y + step(1), pose_.yaw + step(2)};
    for (std::size_t i = 0; i < landmarks.size(); ++i)
      landmarks[i] += step.segment<2>(3 + 2 * static_cast<Eigen::Index>(i));
    p_ = ((Eigen::MatrixXd::Identity(p_.rows(), p_.cols()) - gain * h) * p_).eval();
  }
  [[nodiscard]] Eigen::Matrix2d covariance(std::size_t landmark) const {
    const auto at = 3 + 2 * static_cast<Eigen::Index>(landmark);
    return p_.block<2, 2>(at, at);
  }
  std::vector<int> ids{};
  std::vector<Eigen::Vector2d> landmarks{};

 private:
  void add(const LandmarkObservation& seen) {
    Eigen::Matrix<double, 2, 3> by_pose = Eigen::Matrix<double, 2, 3>::Identity();
    const Eigen::Vector2d arm = pose_.rotation() * seen.point;
    by_pose.col(2) << -arm.y(), arm.x();
    const auto size = p_.rows();
    const Eigen::MatrixXd across = by_pose * p_.topRows(3);
    Eigen::MatrixXd grown(size + 2, size + 2);
    grown.topLeftCorner(size, size) = p_;
    grown.bottomLeftCorner(2, size) = across;
    grown.topRightCorner(size, 2) = across.transpose();
    grown.bottomRightCorner<2, 2>() =
        by_pose * p_.topLeftCorner<3, 3>() * by_pose.transpose() +
        pose_.rotation() * seen.covariance * pose_.rotation().transpose();
    p_ = grown;
    ids.push_back(*seen.id);
    landmarks.push_back(pose_ * seen.point);
  }

  Pose2 pose_{};
  Eigen::MatrixXd p_ = Eigen::MatrixXd::Zero(3, 3);
};

/// Where noise is small all is linear, and the filter is exact.
TEST(MapLandmarks, AgreesWithTheFilterWhereThatIsExact) {
  const Round round = drive_round({.steps = 25, .names = true, .noise = 0.01}, 3);
  const LandmarkMappingOptions plain{.baseline_min_m = 0.0, .robust_width = 1000.0};
  const LandmarkMapping mapping = map_landmarks(round.graph, round.seen, plain);
  EkfSlam filter;
  for (std::size_t i = 0; i < round.seen.size(); ++i) {
    if (i > 0) {
      const Pose2 motion = round.graph.poses[i - 1].inverse() * round.graph.poses[i];
      filter.move(motion, rotated(planar_covariance(kStepSigmaM, kStepSigmaRad),
                                  Eigen::Matrix2d(Eigen::Matrix2d::Identity())));
    }
    for (const LandmarkObservation& seen : round.seen[i]) filter.see(seen);
  }
  ASSERT_GE(mapping.landmarks.size(), 4U);
  for (const FoundLandmark& found : mapping.landmarks) {
    const auto at = std::ranges::find(filter.ids, found.id);
    ASSERT_NE(at, filter.ids.end());
    const auto k = static_cast<std::size_t>(at - filter.ids.begin());
    EXPECT_LT((found.position - filter.landmarks[k]).norm(), 2e-5) << found.id;
    EXPECT_LT((found.covariance - filter.covariance(k)).norm(), 0.01 * found.covariance.norm())
        << found.id;
  }
}

TEST(MapLandmarks, RefusesWhatDoesNotBelongTogether) {
  PoseGraph graph;
  graph.poses.resize(2);
  const std::vector<std::vector<LandmarkObservation>> one(1);
  EXPECT_THROW((void)map_landmarks(graph, one, {}), UsageError);
  EXPECT_THROW((void)map_landmarks(graph, {}, {.sightings_min = 1}), OptionsError);
  EXPECT_TRUE(map_landmarks({}, {}, {}).landmarks.empty());
}

TEST(FollowLandmarks, EachSightingIsInOneTrack) {
  const Round round = drive_round({}, 13);
  std::vector<PoseWithCovariance2> motions(round.truth.size());
  for (std::size_t i = 1; i < motions.size(); ++i) {
    motions[i] = {round.graph.poses[i - 1].inverse() * round.graph.poses[i],
                  planar_covariance(kStepSigmaM, kStepSigmaRad)};
  }
  const auto tracks = follow_landmarks(motions, round.seen, 0.05);
  std::vector<std::vector<int>> times(round.seen.size());
  for (std::size_t i = 0; i < times.size(); ++i) times[i].assign(round.seen[i].size(), 0);
  const LandmarkMap map = hall_map();
  for (const LandmarkTrack& track : tracks) {
    for (const Sighting& s : track.sightings) ++times[s.node][s.observation];
    const auto nearest = [&](const Sighting& s) {
      const Eigen::Vector2d at = round.truth[s.node] * round.seen[s.node][s.observation].point;
      return map.within(at, 0.5);
    };
    for (const Sighting& s : track.sightings)
      EXPECT_EQ(nearest(s), nearest(track.sightings.front()));
  }
  for (const auto& reading : times) {
    for (const int count : reading) EXPECT_EQ(count, 1);
  }
}

/// A laser's beams on a circle of that radius, or on a strip of 10 cm where it is 0, of a robot
/// that passes by.
std::vector<std::vector<LandmarkObservation>> passed_by(double radius_m,
                                                        const std::vector<Pose2>& poses, Rng& rng) {
  std::vector<std::vector<LandmarkObservation>> seen;
  const Eigen::Vector2d centre(0.0, 3.0);
  for (const Pose2& pose : poses) {
    const Eigen::Vector2d at = pose.inverse() * centre;
    LandmarkObservation o = observed(at.norm(), std::atan2(at.y(), at.x()), 0.01, 0.001);
    const double half = radius_m > 0.0 ? 0.9 * radius_m : 0.05;
    double mean = 0.0;
    for (int i = -3; i <= 3; ++i) {
      const double beside = half * i / 3.0;
      const double depth = radius_m > 0.0 ? std::sqrt(radius_m * radius_m - beside * beside) : 0.0;
      o.beams_beside_m.push_back(beside);
      o.beams_beyond_m.push_back(-depth + rng.normal(0.0, 0.01));
      mean += depth / 7.0;
    }
    for (double& beyond : o.beams_beyond_m) beyond += mean;
    o.point -= mean * o.direction;
    seen.push_back({o});
  }
  return seen;
}

TEST(RadiusOf, TellsRoundFromFlat) {
  Rng rng(4);
  std::vector<Pose2> poses;
  std::vector<Sighting> sightings;
  for (std::size_t i = 0; i < 30; ++i) {
    poses.push_back({-3.0 + 0.2 * static_cast<double>(i), 0.0, 0.0});
    sightings.push_back({i, 0});
  }
  for (const double radius : {0.0, 0.04, 0.15, 0.3}) {
    const auto seen = passed_by(radius, poses, rng);
    const LandmarkScene scene{seen, {}};
    EXPECT_NEAR(radius_of(sightings, 0.5, scene, poses), radius, 0.01) << radius;
  }
}

TEST(WithoutCommonMotion, WhatMovesAllTogetherIsNoUncertainty) {
  const std::vector<Eigen::Vector2d> points{{0.0, 0.0}, {4.0, 1.0}, {-2.0, 3.0}};
  Eigen::MatrixXd motions(6, 3);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d& p = points[static_cast<std::size_t>(i)];
    motions.block<2, 3>(2 * i, 0) << 1.0, 0.0, -p.y(), 0.0, 1.0, p.x();
  }
  const Eigen::Matrix3d spread = Eigen::Vector3d(1.0, 2.0, 0.5).asDiagonal();
  const Eigen::MatrixXd common = motions * spread * motions.transpose();
  EXPECT_LT(without_common_motion(common, points).norm(), 1e-12);
  const Eigen::MatrixXd own = Eigen::MatrixXd::Identity(6, 6);
  const Eigen::MatrixXd kept = without_common_motion(own + common, points);
  EXPECT_NEAR(kept.trace(), 3.0, 1e-9) << "six unknowns less three motions";
}

TEST(SeesThrough, OnlyWhereBeamsEndBeyond) {
  LaserScan scan{.angle_min_rad = -kPi / 2.0,
                 .angle_increment_rad = radians(0.25),
                 .range_max_m = 30.0,
                 .ranges_m = std::vector<float>(721, 5.0F)};
  const KeyView key{&scan, Pose2{0.1, 0.0, 0.0}, Tangent2::Zero()};
  EXPECT_EQ(sees_through(key, {3.0, 0.0}), true);
  EXPECT_EQ(sees_through(key, {5.1, 0.0}), false) << "the wall itself";
  EXPECT_EQ(sees_through(key, {7.0, 0.0}), std::nullopt) << "behind it";
  EXPECT_EQ(sees_through(key, {-3.0, 0.0}), std::nullopt) << "no beam goes there";
  scan.ranges_m[360] = 3.0F;
  EXPECT_EQ(sees_through(key, {3.1, 0.0}), false) << "one beam meets it";
}

}  // namespace
}  // namespace loopstone::test
