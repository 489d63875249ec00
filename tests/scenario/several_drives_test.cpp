// Going on with a map on another day: a second drive of the same building, and of another one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "support/usual_figure.hpp"
#include "support/world_drive.hpp"

namespace loopstone {
namespace {

using test::drive_in;
using Drive = test::WorldDrive;

MapResult map_both(const Drive& first, const Drive& second, Threads threads = {}) {
  Mapper mapper(RobotModel{}, MapOptions{}, threads);
  for (const SensorMessage& message : first.messages) mapper.add(message);
  mapper.begin_drive();
  for (const SensorMessage& message : second.messages) mapper.add(message);
  return mapper.finish();
}

/// Rms of the second drive's positions in the frame of the first one [m].
double second_error_m(const MapResult& result, const Drive& first, const Drive& second) {
  const std::vector<Trajectory> drives = result.trajectories();
  // The map's frame is where the first drive began; what its own errors turn it by is taken out.
  const AbsoluteError of_first = absolute_error(drives[0], first.truth, Alignment::kSe2);
  double squares = 0.0;
  for (const StampedPose2& pose : drives[1].poses()) {
    const Pose2 truth = *second.truth.at_clamped(pose.stamp);
    const Pose2 off = truth.inverse() * (of_first.reference_T_estimate * pose.pose);
    squares += off.translation().squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(drives[1].size()));
}

TEST(SeveralDrives, ASecondDriveOfTheBuildingIsFoundOnTheMapOfTheFirst) {
  const World office = make_world("office", 1);
  const Drive first = drive_in(office, 1, 240.0, 0, 0.0);
  // On a clock of its own, which is behind.
  const Drive second = drive_in(office, 2, 90.0, 3, -5000.0);
  const MapResult result = map_both(first, second);
  ASSERT_EQ(result.drives.size(), 1U);
  EXPECT_TRUE(result.drives[0].is_joined());
  const std::vector<Trajectory> drives = result.trajectories();
  ASSERT_EQ(drives.size(), 2U);
  EXPECT_EQ(drives[0].size(), first.truth.size());
  EXPECT_EQ(drives[1].size(), second.truth.size());
  EXPECT_EQ(drives[1].front().stamp, second.truth.front().stamp);
  EXPECT_TRUE(test::as_usual(second_error_m(result, first, second), 0.02));
}

TEST(SeveralDrives, ADriveOfAnotherBuildingStaysBesideTheMap) {
  const Drive first = drive_in(make_world("office", 1), 1, 120.0, 0, 0.0);
  const Drive second = drive_in(make_world("warehouse", 4), 2, 60.0, 0, 100000.0);
  const MapResult result = map_both(first, second);
  ASSERT_EQ(result.drives.size(), 1U);
  EXPECT_FALSE(result.drives[0].is_joined());
  EXPECT_EQ(result.verdict.overall, Verdict::kBad);
  EXPECT_TRUE(std::ranges::any_of(result.warnings, [](const std::string& warning) {
    return warning.find("drawn beside it") != std::string::npos;
  }));
  const auto range_of = [](const Trajectory& trajectory) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const StampedPose2& pose : trajectory.poses()) {
      low = std::min(low, pose.pose.x);
      high = std::max(high, pose.pose.x);
    }
    return std::pair{low, high};
  };
  const std::vector<Trajectory> drives = result.trajectories();
  EXPECT_GT(range_of(drives[1]).first, range_of(drives[0]).second + 1.0);
}

TEST(SeveralDrives, AnotherBuildingWhoseRoomsLookAlikeIsNotTakenForTheFirst) {
  const Drive first = drive_in(make_world("rooms", 1), 1, 90.0, 0, 0.0);
  const Drive second = drive_in(make_world("rooms", 2), 2, 60.0, 0, 0.0);
  const MapResult result = map_both(first, second);
  ASSERT_EQ(result.drives.size(), 1U);
  EXPECT_FALSE(result.drives[0].is_joined());
}

TEST(SeveralDrives, WherePlacesLookAlikeADriveIsFoundRightlyOrNotAtAll) {
  for (const char* const name : {"rooms", "wings", "aisles"}) {
    const World world = make_world(name, 1);
    const Drive first = drive_in(world, 1, 120.0, 0, 0.0);
    const Drive second = drive_in(world, 2, 45.0, 5, 0.0);
    const MapResult result = map_both(first, second);
    ASSERT_EQ(result.drives.size(), 1U);
    if (!result.drives[0].is_joined()) continue;
    EXPECT_LT(second_error_m(result, first, second), 0.2) << name;
  }
}

TEST(SeveralDrives, ABuildingThatWasChangedMeanwhileIsFoundAgain) {
  const World office = make_world("office", 2);
  const Drive first = drive_in(office, 1, 240.0, 0, 0.0);
  // A third of the furniture is gone.
  World changed = office;
  std::size_t count = 0;
  std::erase_if(changed.plan.boxes, [&](const Box& box) {
    return box.length_m < 2.0 && box.width_m < 2.0 && count++ % 3 == 0;
  });
  ASSERT_LT(changed.plan.boxes.size(), office.plan.boxes.size());
  const Drive second = drive_in(changed, 2, 90.0, 2, 300.0);
  const MapResult result = map_both(first, second);
  ASSERT_EQ(result.drives.size(), 1U);
  ASSERT_TRUE(result.drives[0].is_joined());
  EXPECT_TRUE(test::as_usual(second_error_m(result, first, second), 0.02));
}

TEST(SeveralDrives, SameBytesForAnyNumberOfThreadsAndAcrossASavedState) {
  const World office = make_world("office", 1);
  const Drive first = drive_in(office, 1, 60.0, 0, 0.0);
  const Drive second = drive_in(office, 2, 30.0, 0, 0.0);
  const std::string one = format_tum(map_both(first, second, {1}).trajectory);
  EXPECT_EQ(one, format_tum(map_both(first, second, {4}).trajectory));
  Mapper before(RobotModel{}, MapOptions{}, {2});
  for (const SensorMessage& message : first.messages) before.add(message);
  Mapper after(RobotModel{}, MapOptions{}, {2});
  after.restore_state(before.save_state().get());
  after.begin_drive();
  for (const SensorMessage& message : second.messages) after.add(message);
  EXPECT_EQ(one, format_tum(after.finish().trajectory));
}

TEST(SeveralDrives, ADriveWithoutScansIsNone) {
  const Drive first = drive_in(make_world("office", 1), 1, 20.0, 0, 0.0);
  Mapper mapper(RobotModel{}, MapOptions{});
  mapper.begin_drive();
  for (const SensorMessage& message : first.messages) mapper.add(message);
  mapper.begin_drive();
  mapper.begin_drive();
  const MapResult result = mapper.finish();
  EXPECT_TRUE(result.drives.empty());
  EXPECT_EQ(result.trajectory.size(), first.truth.size());
}

}  // namespace
}  // namespace loopstone
