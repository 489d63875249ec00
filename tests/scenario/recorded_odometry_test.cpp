// Dead reckoning of recorded logs against figures that others published.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "loopstone/evaluation/relations.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/relations_file.hpp"
#include "loopstone/odometry/dead_reckoning.hpp"
#include "support/recorded_data.hpp"

namespace loopstone::test {
namespace {

DeadReckoningResult dead_reckon(const std::string& path, const OdometryOptions& options = {}) {
  const auto log = open_log(path);
  DeadReckoner reckoner(RobotModel{}.wheels, options);
  while (const auto message = log->next()) reckoner.add(*message);
  return reckoner.finish();
}

struct Published {
  double mean_m;
  double std_m;
  double rotation_deg;
  std::int64_t pairs;
};

/// The relations metric of raw odometry, to the digits that were published.
void expect_published(const std::string& name, const Published& published) {
  const std::string log = recorded_data("carmen/" + name + ".clf");
  const std::string relations = recorded_data("carmen/" + name + ".relations");
  if (log.empty() || relations.empty()) {
    GTEST_SKIP() << "carmen/" << name << " is not among the recorded data; set LOOPSTONE_DATA";
  }
  const DeadReckoningResult odometry = dead_reckon(log);
  EXPECT_EQ(odometry.scans_without_pose, 0);
  const RelationsError error = relations_error(odometry.trajectory, read_relations(relations));
  EXPECT_EQ(error.pairs, published.pairs);
  EXPECT_TRUE(error.missing.empty());
  EXPECT_EQ(error.pairs_interpolated, 0) << "every relation has the stamp of a scan";
  EXPECT_NEAR(error.translation_m.mean, published.mean_m, 5e-4);
  EXPECT_NEAR(error.translation_m.std, published.std_m, 5e-4);
  EXPECT_NEAR(degrees(error.rotation_rad.mean), published.rotation_deg, 5e-3);
}

TEST(RecordedOdometry, IntelScoresAsPublished) {
  expect_published("intel", {7.373, 14.459, 39.17, 2984});
}

TEST(RecordedOdometry, AcesScoresAsPublished) {
  expect_published("aces", {0.5636, 2.7247, 2.33, 1279});
}

TEST(RecordedOdometry, UcsdSetsEndWhereOthersEnd) {
  const std::string folder = recorded_data("ucsd/sensors");
  if (folder.empty())
    GTEST_SKIP() << "ucsd/sensors is not among the recorded data; set LOOPSTONE_DATA";
  // Others integrated the raw gyro. The last poses of others_results/*/odometry_{20,21}_imu.npz;
  // the wheels stand by then, so it does not matter that their last stamp is the gyro's and ours
  // the encoders'.
  struct Case {
    const char* set;
    Pose2 others;
    double path_m;
  };
  for (const Case& c : {Case{"#20", {-2.12606995, -1.93213671, 0.042454}, 95.8748},
                        Case{"#21", {-2.5262499, -1.83680741, -0.921527}, 91.7771}}) {
    OdometryOptions raw;
    raw.use_standstill = false;
    const Trajectory trajectory = dead_reckon(folder + c.set, raw).trajectory;
    const Pose2 end = trajectory.back().pose;
    EXPECT_LT((end.translation() - c.others.translation()).norm(), 0.01) << c.set;
    EXPECT_LT(std::abs(wrap_angle(end.yaw - c.others.yaw)), radians(0.1)) << c.set;
    EXPECT_NEAR(trajectory.path_length_m(), c.path_m, 0.02) << c.set;
    // The bias that we remove turns the path by a few degrees, no more.
    const Pose2 corrected = dead_reckon(folder + c.set).trajectory.back().pose;
    EXPECT_LT(std::abs(wrap_angle(corrected.yaw - c.others.yaw)), radians(5.0)) << c.set;
    EXPECT_GT(std::abs(wrap_angle(corrected.yaw - c.others.yaw)), radians(1.0)) << c.set;
  }
}

}  // namespace
}  // namespace loopstone::test
