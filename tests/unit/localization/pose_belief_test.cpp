#include "loopstone/localization/pose_belief.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "loopstone/localization/weighted_moments.hpp"
#include "support/generators.hpp"

namespace loopstone::test {
namespace {

PoseBelief::Proposal proposal(const Pose2& pose, double log_mass = 0.0, double sigma_m = 0.05) {
  PoseBelief::Proposal made{.log_mass = log_mass};
  made.map_T_robot.pose = pose;
  made.map_T_robot.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, 0.001;
  return made;
}

double total_mass(const PoseBelief& belief) {
  double sum = 0.0;
  for (const PlaceBelief& place : belief.places()) sum += std::exp(place.log_mass);
  return sum;
}

/// By joining every pair of poses whose cells touch, in no clever way.
std::vector<int> group_naively(const std::vector<Pose2>& poses, double cell_m, int headings) {
  const auto cell = [](double value, double size) {
    return static_cast<int>(std::floor(value / size));
  };
  const double cell_rad = 2.0 * kPi / headings;
  std::vector<int> labels(poses.size());
  std::iota(labels.begin(), labels.end(), 0);
  const auto touch = [&](const Pose2& a, const Pose2& b) {
    const int turn = std::abs(cell(a.yaw + kPi, cell_rad) - cell(b.yaw + kPi, cell_rad)) % headings;
    return std::abs(cell(a.x, cell_m) - cell(b.x, cell_m)) <= 1 &&
           std::abs(cell(a.y, cell_m) - cell(b.y, cell_m)) <= 1 &&
           (turn <= 1 || turn == headings - 1);
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (std::size_t k = 0; k < poses.size(); ++k) {
        if (touch(poses[i], poses[k]) && labels[k] < labels[i]) {
          labels[i] = labels[k];
          changed = true;
        }
      }
    }
  }
  return labels;
}

RC_GTEST_PROP(GroupPoses, AreTheNaiveOnes, ()) {
  const auto count = *rc::gen::inRange(1, 40);
  std::vector<Pose2> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back({*between(-2.0, 2.0), *between(-2.0, 2.0), *between(-3.1, 3.1)});
  // Headings divide the circle into a whole number of cells, no smaller than asked for: 7.
  const std::vector<int> labels = group_poses(poses, 0.3, 2.0 * kPi / 7.5);
  const std::vector<int> naive = group_naively(poses, 0.3, 7);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t k = 0; k < poses.size(); ++k)
      RC_ASSERT((labels[i] == labels[k]) == (naive[i] == naive[k]));
  }
}

TEST(WeightedMoments, AverageHeadingsOnTheCircle) {
  const std::vector<Pose2> poses{{1.0, 0.0, kPi - 0.1}, {3.0, 0.0, -kPi + 0.1}};
  const std::vector<double> weights{0.5, 0.5};
  const PoseWithCovariance2 moments = weighted_moments(poses, weights);
  EXPECT_NEAR(moments.pose.x, 2.0, 1e-12);
  EXPECT_NEAR(std::abs(moments.pose.yaw), kPi, 1e-12);
  EXPECT_NEAR(moments.covariance(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(moments.covariance(2, 2), 0.01, 1e-9);
}

TEST(PoseBelief, EqualPlacesKeepEqualBelief) {
  // One filter would drift into one of them by chance within some dozen draws.
  PoseBelief belief({.particles_max = 400, .particles_min = 50}, 1, {});
  const std::vector<PoseBelief::Proposal> proposals{proposal({0.0, 0.0, 0.0}),
                                                    proposal({10.0, 0.0, 0.0})};
  belief.add(proposals, 1.0);
  ASSERT_EQ(belief.places().size(), 2U);
  const auto alike = [](std::span<const Pose2> poses, std::span<double> out) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double off = std::min(std::abs(poses[i].x), std::abs(poses[i].x - 10.0));
      out[i] = -0.5 * std::pow(std::hypot(off, poses[i].y) / 0.03, 2);
    }
  };
  for (int step = 0; step < 200; ++step) {
    belief.predict([](const Pose2& pose, Rng& noise) {
      return Pose2{pose.x + noise.normal(0.0, 0.02), pose.y + noise.normal(0.0, 0.02), pose.yaw};
    });
    belief.update(alike);
    belief.settle();
    // What was injected around a place may be one of its own for a moment, with next to no belief
    // in it.
    ASSERT_GE(belief.places().size(), 2U) << "after " << step;
    // Their evidence is estimated with particles, so belief does a random walk, but a short one.
    ASSERT_GT(std::exp(belief.places()[1].log_mass), 0.02) << "after " << step;
  }
  EXPECT_GT(std::abs(belief.places()[0].moments.pose.x - belief.places()[1].moments.pose.x), 9.0);
  EXPECT_NEAR(total_mass(belief), 1.0, 1e-9);
}

TEST(PoseBelief, EvidenceDecidesBetweenPlacesAsBayesSays) {
  PoseBelief belief({}, 2, {});
  const std::vector<PoseBelief::Proposal> proposals{proposal({0.0, 0.0, 0.0}, std::log(0.8)),
                                                    proposal({10.0, 0.0, 0.0}, std::log(0.2))};
  belief.add(proposals, 1.0);
  belief.update([](std::span<const Pose2> poses, std::span<double> out) {
    for (std::size_t i = 0; i < poses.size(); ++i) out[i] = poses[i].x > 5.0 ? std::log(8.0) : 0.0;
  });
  belief.settle();
  ASSERT_EQ(belief.places().size(), 2U);
  // 0.2 * 8 against 0.8: two to one.
  EXPECT_NEAR(std::exp(belief.places()[0].log_mass), 2.0 / 3.0, 1e-9);
  EXPECT_GT(belief.places()[0].moments.pose.x, 9.0);
}

TEST(PoseBelief, ACloudThatFallsApartIsSeveralPlacesAndGrowsTogetherAgain) {
  PoseBelief belief({}, 3, {});
  const std::vector<PoseBelief::Proposal> wide{proposal({0.0, 0.0, 0.0}, 0.0, 1.0)};
  belief.add(wide, 1.0);
  ASSERT_EQ(belief.places().size(), 1U);
  belief.update([](std::span<const Pose2> poses, std::span<double> out) {
    for (std::size_t i = 0; i < poses.size(); ++i)
      out[i] = std::abs(std::abs(poses[i].x) - 1.5) < 0.2 ? 0.0 : -40.0;
  });
  belief.settle();
  ASSERT_EQ(belief.places().size(), 2U);
  EXPECT_LT(belief.places()[0].moments.pose.x * belief.places()[1].moments.pose.x, 0.0);
  EXPECT_NE(belief.places()[0].id, belief.places()[1].id);
  belief.predict([](const Pose2& pose, Rng&) { return Pose2{0.1 * pose.x, pose.y, pose.yaw}; });
  belief.settle();
  EXPECT_EQ(belief.places().size(), 1U);
  EXPECT_NEAR(total_mass(belief), 1.0, 1e-9);
}

TEST(PoseBelief, NewPlacesGetTheirShareAndNoMore) {
  PoseBelief belief({}, 4, {});
  const std::vector<PoseBelief::Proposal> first{proposal({0.0, 0.0, 0.0})};
  belief.add(first, 0.3);
  EXPECT_NEAR(std::exp(belief.places()[0].log_mass), 1.0, 1e-9);
  const std::vector<PoseBelief::Proposal> more{proposal({5.0, 0.0, 0.0}),
                                               proposal({9.0, 0.0, 0.0})};
  belief.add(more, 0.3);
  ASSERT_EQ(belief.places().size(), 3U);
  EXPECT_NEAR(std::exp(belief.places()[0].log_mass), 0.7, 1e-9);
  EXPECT_NEAR(std::exp(belief.places()[1].log_mass), 0.15, 1e-9);
}

TEST(PoseBelief, AScanThatNothingExplainsChangesNothing) {
  PoseBelief belief({}, 5, {});
  const std::vector<PoseBelief::Proposal> first{proposal({0.0, 0.0, 0.0})};
  belief.add(first, 1.0);
  const std::vector<Pose2> before = belief.particles();
  belief.update([](std::span<const Pose2>, std::span<double> out) {
    std::fill(out.begin(), out.end(), -std::numeric_limits<double>::infinity());
  });
  EXPECT_EQ(belief.particles(), before);
  EXPECT_NEAR(total_mass(belief), 1.0, 1e-9);
}

TEST(PoseBelief, FewParticlesWhereThePoseIsKnownManyWhereItIsNot) {
  PoseBelief belief({.particles_max = 5000, .particles_min = 50}, 6, {});
  const std::vector<PoseBelief::Proposal> wide{proposal({0.0, 0.0, 0.0}, 0.0, 1.0)};
  belief.add(wide, 1.0);
  const std::size_t many = belief.particle_count();
  belief.update([](std::span<const Pose2> poses, std::span<double> out) {
    for (std::size_t i = 0; i < poses.size(); ++i)
      out[i] = -0.5 * poses[i].translation().squaredNorm() / 0.0025;
  });
  belief.settle();
  EXPECT_LT(belief.particle_count() * 5, many);
  EXPECT_GE(belief.particle_count(), 50U);
}

TEST(PoseBelief, TheSameBytesForAnyNumberOfThreads) {
  const auto run = [](Threads threads) {
    PoseBelief belief({}, 7, threads);
    const std::vector<PoseBelief::Proposal> first{proposal({0.0, 0.0, 0.0}, 0.0, 0.5)};
    belief.add(first, 1.0);
    for (int step = 0; step < 5; ++step) {
      belief.predict([](const Pose2& pose, Rng& noise) {
        return Pose2{pose.x + noise.normal(0.1, 0.02), pose.y + noise.normal(0.0, 0.02), pose.yaw};
      });
      belief.update([&](std::span<const Pose2> poses, std::span<double> out) {
        for (std::size_t i = 0; i < poses.size(); ++i)
          out[i] = -0.5 * std::pow((poses[i].x - 0.1 * step) / 0.1, 2);
      });
      belief.settle();
    }
    return belief.particles();
  };
  EXPECT_EQ(run({1}), run({4}));
}

}  // namespace
}  // namespace loopstone::test
