// Drives that were mapped by themselves, joined to one map.

#include "loopstone/slam/joined_drives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/usual_figure.hpp"
#include "support/world_drive.hpp"

namespace loopstone {
namespace {

using test::drive_in;
using test::WorldDrive;
using Record = std::shared_ptr<const DriveRecord>;

Record record_of_drive(const WorldDrive& drive, Threads threads = {2}) {
  Mapper mapper(RobotModel{}, MapOptions{}, threads);
  for (const SensorMessage& message : drive.messages) mapper.add(message);
  (void)mapper.judge_robot();
  return std::make_shared<const DriveRecord>(record_of(mapper.save_state().get(), MapOptions{}));
}

/// Rms of all positions of all drives, in one frame of which nothing is taken out but where the
/// first drive of the map lies [m].
double error_m(const MapResult& result, const std::vector<const WorldDrive*>& drives) {
  const std::vector<Trajectory> mapped = result.trajectories();
  EXPECT_EQ(mapped.size(), drives.size());
  const Pose2 truth_T_map =
      absolute_error(mapped.front(), drives.front()->truth, Alignment::kSe2).reference_T_estimate;
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    for (const StampedPose2& pose : mapped[i].poses()) {
      const Pose2 truth = *drives[i]->truth.at_clamped(pose.stamp);
      squares += (truth.inverse() * (truth_T_map * pose.pose)).translation().squaredNorm();
      ++count;
    }
  }
  return std::sqrt(squares / static_cast<double>(count));
}

/// Three drives of an office, from three of its places, and one of a warehouse.
class JoinedDrivesOfAnOffice : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const World office = make_world("office", 1);
    drives_ = new std::vector<WorldDrive>{
        drive_in(office, 1, 150.0, 0, 0.0), drive_in(office, 2, 90.0, 3, -5000.0),
        drive_in(make_world("warehouse", 4), 2, 60.0, 0, 100.0), drive_in(office, 5, 90.0, 2, 0.0)};
    records_ = new std::vector<Record>;
    for (const WorldDrive& drive : *drives_) records_->push_back(record_of_drive(drive));
  }
  static void TearDownTestSuite() {
    delete records_;
    delete drives_;
    records_ = nullptr;
    drives_ = nullptr;
  }
  static JoinedDrives join(const std::vector<std::size_t>& order, Threads threads = {2}) {
    JoinedDrives joined(MapOptions{}, threads);
    for (const std::size_t i : order) joined.add((*records_)[i]);
    return joined;
  }
  static std::vector<const WorldDrive*> truths(const std::vector<std::size_t>& order) {
    std::vector<const WorldDrive*> truths;
    for (const std::size_t i : order) truths.push_back(&(*drives_)[i]);
    return truths;
  }

  static inline std::vector<WorldDrive>* drives_ = nullptr;
  static inline std::vector<Record>* records_ = nullptr;
};

TEST_F(JoinedDrivesOfAnOffice, AreOneMapWithoutThoseOfAnotherBuilding) {
  const JoinedDrives joined = join({0, 1, 2, 3});
  EXPECT_TRUE(joined.is_joined(0));
  EXPECT_TRUE(joined.is_joined(1));
  EXPECT_FALSE(joined.is_joined(2));
  EXPECT_TRUE(joined.is_joined(3));
  const MapResult result = joined.finish(RobotModel{});
  EXPECT_EQ(result.drives.size(), 2U);
  EXPECT_NE(result.verdict.overall, Verdict::kBad) << result.verdict.sentence;
  EXPECT_TRUE(test::as_usual(error_m(result, truths({0, 1, 3})), 0.02));
}

TEST_F(JoinedDrivesOfAnOffice, WhereTheFirstIsOfAnotherBuildingTheMostCount) {
  const JoinedDrives joined = join({2, 0, 1});
  EXPECT_FALSE(joined.is_joined(0));
  EXPECT_TRUE(joined.is_joined(1));
  EXPECT_TRUE(joined.is_joined(2));
  const MapResult result = joined.finish(RobotModel{});
  EXPECT_TRUE(test::as_usual(error_m(result, truths({0, 1})), 0.02));
}

TEST_F(JoinedDrivesOfAnOffice, SameBytesForAnyNumberOfThreads) {
  const std::string one = format_tum(join({0, 1}, {1}).finish(RobotModel{}).trajectory);
  EXPECT_EQ(one, format_tum(join({0, 1}, {4}).finish(RobotModel{}).trajectory));
}

TEST_F(JoinedDrivesOfAnOffice, SameBytesOnAnotherDay) {
  const JoinedDrives before = join({0, 1});
  const auto again = [](const auto& value) {
    ByteWriter writer;
    writer(value);
    const std::string bytes = writer.take();
    ByteReader reader(bytes, {});
    auto read = value;
    reader(read);
    reader.end();
    return read;
  };
  std::vector<Record> records;
  for (std::size_t i = 0; i < before.size(); ++i) {
    records.push_back(std::make_shared<const DriveRecord>(again(before.record(i))));
    EXPECT_TRUE(is_sound(*records.back(), 1e4));
  }
  std::vector<DrivePair> pairs;
  for (const DrivePair& pair : before.pairs()) {
    pairs.push_back(again(pair));
    pairs.back().older = pair.older;
    pairs.back().newer = pair.newer;
  }
  std::vector<DrivePlacement> placements;
  for (const DrivePlacement& placement : before.placements())
    placements.push_back(again(placement));
  JoinedDrives after(MapOptions{}, {2});
  after.restore(std::move(records), std::move(pairs), std::move(placements));
  after.add((*records_)[3]);
  EXPECT_EQ(format_tum(join({0, 1, 3}).finish(RobotModel{}).trajectory),
            format_tum(after.finish(RobotModel{}).trajectory));
}

TEST_F(JoinedDrivesOfAnOffice, OneThatIsRemovedLeavesTheOthersAsTheyHoldTogether) {
  JoinedDrives joined = join({0, 1, 3});
  joined.remove(1);
  ASSERT_EQ(joined.size(), 2U);
  EXPECT_TRUE(joined.is_joined(1));
  EXPECT_TRUE(test::as_usual(error_m(joined.finish(RobotModel{}), truths({0, 3})), 0.02));
}

TEST_F(JoinedDrivesOfAnOffice, EachVisitIsDrawnByItself) {
  const JoinedDrives joined = join({0, 1});
  std::vector<std::size_t> seen;
  const MapResult result = joined.finish(RobotModel{}, [&](const DriveVisit& visit) {
    std::size_t cells = 0;
    for (const std::uint8_t observed : visit.map.observed.cells()) cells += observed;
    EXPECT_GT(cells, 10000U);
    seen.push_back(visit.drive);
  });
  EXPECT_THAT(seen, testing::ElementsAre(0U, 1U));
  EXPECT_TRUE(result.map.log_odds.empty());
}

TEST_F(JoinedDrivesOfAnOffice, WhatContradictsItselfIsRefused) {
  const JoinedDrives good = join({0, 1});
  const std::vector<Record> records{(*records_)[0], (*records_)[1]};
  JoinedDrives joined(MapOptions{}, {1});
  std::vector<DrivePlacement> placements = good.placements();
  placements[1].covered.pop_back();
  EXPECT_THROW(joined.restore(records, good.pairs(), placements), UsageError);
  std::vector<DrivePair> pairs = good.pairs();
  pairs.back().closures.front().to_submap.index = 10000;
  EXPECT_THROW(joined.restore(records, pairs, good.placements()), UsageError);
  pairs = good.pairs();
  pairs.back().closures.front().from_T_to.yaw = 1e300;  // solvers would wrap it for ever
  EXPECT_THROW(joined.restore(records, pairs, good.placements()), UsageError);
  DriveRecord far = *records.front();
  EXPECT_TRUE(is_sound(far, 1e4));
  far.back_end.chain.submaps.front().keys.front().local_T_robot.yaw = 1e300;
  EXPECT_FALSE(is_sound(far, 1e4));
}

TEST(JoinedDrives, TwoDrivesFromTheSameDockAreJoinedThoughTheyLieAlike) {
  // The second begins where the first did, faces nearly as it did: what lies to what says nothing.
  const World office = make_world("office", 5);
  JoinedDrives joined(MapOptions{}, {2});
  for (const std::uint64_t seed : {1U, 3U})
    joined.add(record_of_drive(drive_in(office, seed, 60.0, 0, 0.0)));
  EXPECT_TRUE(joined.is_joined(0) && joined.is_joined(1));
}

TEST(JoinedDrives, WherePlacesLookAlikeADriveIsJoinedRightlyOrNotAtAll) {
  for (const char* const name : {"rooms", "wings", "aisles"}) {
    const World world = make_world(name, 1);
    const WorldDrive first = drive_in(world, 1, 120.0, 0, 0.0);
    const WorldDrive second = drive_in(world, 2, 45.0, 5, 0.0);
    JoinedDrives joined(MapOptions{}, {2});
    joined.add(record_of_drive(first));
    joined.add(record_of_drive(second));
    if (!joined.is_joined(0) || !joined.is_joined(1)) continue;
    EXPECT_LT(error_m(joined.finish(RobotModel{}), {&first, &second}), 0.2) << name;
  }
}

/// Two floors that are built alike, whose walls are bent by centimetres, each its own way.
TEST(JoinedDrives, ACopyOfAPlaceIsNotThatPlace) {
  SimulationOptions options;
  choose_realism(options.realism, "usual");
  RealismRecord record;
  const World floors = real_world(make_world("wings", 41), options.realism, 41, record);
  const auto drive = [&](std::uint64_t seed, std::size_t place) {
    return record_of_drive(drive_in(floors, seed, 120.0, place, 0.0));
  };
  JoinedDrives joined(MapOptions{}, {2});
  joined.add(drive(1, 0));
  joined.add(drive(2, 8));
  EXPECT_TRUE(joined.is_joined(0));
  EXPECT_FALSE(joined.is_joined(1));
  const auto was_laid = [](const LoopClosure& closure) {
    return closure.state == ClosureState::kRevoked &&
           closure.reason == ClosureReason::kSurroundings;
  };
  EXPECT_TRUE(std::ranges::any_of(joined.pairs(), [&](const DrivePair& pair) {
    return std::ranges::any_of(pair.closures, was_laid);
  })) << "else this shows nothing";
  // Who drove there as well is told which of them it is.
  joined.add(drive(3, 0));
  EXPECT_TRUE(joined.is_joined(2));
  EXPECT_FALSE(joined.is_joined(1));
}

}  // namespace
}  // namespace loopstone
