// Recorded clouds in space: partial views of objects against their models, pairs of scans with
// their true transforms.

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "support/pose_near.hpp"
#include "support/recorded_data.hpp"

namespace loopstone::test {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Pose3 random_motion(Rng& rng) {
  const Eigen::Vector4d q(rng.normal(), rng.normal(), rng.normal(), rng.normal());
  return {{rng.normal(), rng.normal(), rng.normal()}, Eigen::Quaterniond(q).normalized()};
}

/// All four views, as they are and turned at random, are laid on the model at least as well as by
/// the best of four peers, each from 36 headings: rmse from every observed point to the nearest
/// model point.
void expect_to_fit(const std::string& object, const std::array<double, 4>& reference_m) {
  const std::string folder = recorded_data("ucsd/icp_warm_up/" + object);
  if (folder.empty()) {
    GTEST_SKIP() << "ucsd/icp_warm_up/" << object
                 << " is not among the recorded data; set LOOPSTONE_DATA";
  }
  Points model_points = read_point_cloud(folder + "/model.mat").points;
  for (auto& point : model_points) point *= 1e-3;  // millimetres
  const CloudModel<3> model(model_points);
  Rng rng(71);
  for (std::size_t i = 0; i < reference_m.size(); ++i) {
    const Points view = read_point_cloud(folder + "/" + std::to_string(i) + ".npy").points;
    const auto plain = search_alignment<3>(view, model);
    EXPECT_LE(plain.match.rmse_m, reference_m[i]) << object << " " << i;
    EXPECT_EQ(plain.match.status, MatchStatus::kConverged);
    EXPECT_FALSE(plain.ambiguous);
    EXPECT_EQ(plain.match.pairs, static_cast<int>(view.size()));

    const Pose3 motion = random_motion(rng);
    Points turned;
    for (const auto& point : view) turned.emplace_back(motion * point);
    const auto again = search_alignment<3>(turned, model);
    EXPECT_LE(again.match.rmse_m, reference_m[i]) << object << " " << i << ", turned";
    EXPECT_TRUE(
        pose_near(again.match.target_T_source * motion * plain.match.target_T_source.inverse(),
                  Pose3{}, 0.001, 0.02))
        << object << " " << i;
  }
}

TEST(RecordedClouds, DrillsAreFoundFromNoGuess) {
  expect_to_fit("drill", {0.001967, 0.001920, 0.002387, 0.003215});
}

TEST(RecordedClouds, BottlesAreFoundFromNoGuess) {
  expect_to_fit("liq_container", {0.001379, 0.001439, 0.001258, 0.001424});
}

/// Two scans that overlap in part, from no guess at all, against their true transform.
void expect_to_overlap(const std::string& source, const std::string& target,
                       const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  const std::string folder = recorded_data("clouds");
  if (folder.empty()) {
    GTEST_SKIP() << "clouds is not among the recorded data; set LOOPSTONE_DATA";
  }
  CloudSearchOptions options;
  options.overlap = 0.7;
  const CloudModel<3> model(read_point_cloud(folder + "/" + target).points);
  const auto found =
      search_alignment<3>(read_point_cloud(folder + "/" + source).points, model, options);
  const Pose3 truth{translation, Eigen::Quaterniond(rotation).normalized()};
  EXPECT_EQ(found.match.status, MatchStatus::kConverged);
  EXPECT_TRUE(pose_near(found.match.target_T_source * truth.inverse(), Pose3{}, 0.05, 0.01));
}

TEST(RecordedClouds, OutdoorScansAreFoundFromNoGuess) {
  Eigen::Matrix3d rotation;
  rotation << 0.999925, 0.0121483, -0.00177009, -0.0121523, 0.999924, -0.00228657, 0.00174218,
      0.00230791, 0.999996;
  expect_to_overlap("source.ply", "target.ply", rotation, {0.488882, 0.121214, -0.0253342});
}

TEST(RecordedClouds, ScansFromACarAreFoundFromNoGuess) {
  Eigen::Matrix3d rotation;
  rotation << 0.981715, 0.169605, -0.0864239, -0.152902, 0.973034, 0.172703, 0.113385, -0.15633,
      0.981175;
  expect_to_overlap("car_cloud401.csv", "car_cloud400.csv", rotation,
                    {0.0614127, 0.191433, -0.0338571});
}

}  // namespace
}  // namespace loopstone::test
