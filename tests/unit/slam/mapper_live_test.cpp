// What a mapper tells while the robot drives.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <thread>
#include <variant>
#include <vector>

#include "loopstone/base/option_list.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/live_map.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "ring_world.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using test::ring;
using test::Scanner;
using test::Walls;

const Pose2 kMount{0.14, 0.0, 0.0};
constexpr std::int64_t kStepNs = 100'000'000;

struct Recording {
  std::vector<SensorMessage> messages{};
  std::vector<Pose2> truth{};  ///< of each scan, from the first
};

Stamp stamp_of_scan(std::size_t i) {
  return {1'000'000'000 + static_cast<std::int64_t>(i) * kStepNs};
}

/// 10 scans a second, odometry at 20 that is 2 % too long.
/// \param wheel_scale  of the scan with that number: what odometry makes of the step
template <typename WheelScale>
Recording drive(const std::vector<Eigen::Vector2d>& points, const Walls& walls,
                WheelScale&& wheel_scale) {
  Recording made;
  const auto poses = test::drive_through(points, 0.1, 0.12);
  const Scanner scanner{
      .angle_increment_rad = radians(1.0), .beams = 271, .range_max_m = 20.0, .noise_m = 0.01};
  Rng rng(5);
  Pose2 odometry;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Stamp stamp = stamp_of_scan(i);
    if (i > 0) {
      const Pose2 step = poses[i - 1].inverse() * poses[i];
      const double scale = wheel_scale(i);
      const Pose2 measured{1.02 * scale * step.x, 0.0, scale * step.yaw};
      made.messages.emplace_back(OdometryPose{stamp - Duration{kStepNs / 2},
                                              interpolate(odometry, odometry * measured, 0.5)});
      odometry = odometry * measured;
    }
    made.messages.emplace_back(OdometryPose{stamp, odometry});
    auto scan = test::scan_from(walls, poses[i], kMount, scanner, &rng);
    scan.stamp = stamp;
    made.messages.emplace_back(std::move(scan));
    made.truth.push_back(poses.front().inverse() * poses[i]);
  }
  return made;
}

const std::vector<Eigen::Vector2d> kRoundAndAThird{{1.5, 1.5}, {12.3, 1.6}, {12.4, 8.4},
                                                   {1.6, 8.5}, {1.5, 1.6},  {12.2, 1.5}};

const Recording& recording() {
  static const Recording result = drive(kRoundAndAThird, ring(), [](std::size_t) { return 1.0; });
  return result;
}

struct Live {
  std::vector<MapUpdate> updates{};
  MapResult result{};
};

/// Returns when the back end has come as far as the front end; a robot gives it more time than a
/// test.
void catch_up(Mapper& mapper) { (void)mapper.save_state().get(); }

/// \param often  the back end catches up after so many messages; 0: whenever it does
Live run(const std::vector<SensorMessage>& messages, int threads = 2, std::size_t often = 0) {
  Live live;
  Mapper mapper({}, {}, {threads});
  const auto take = [&] {
    while (auto update = mapper.next_update()) live.updates.push_back(std::move(*update));
  };
  std::size_t added = 0;
  for (const auto& message : messages) {
    mapper.add(message);
    if (often > 0 && ++added % often == 0) catch_up(mapper);
    take();
  }
  live.result = mapper.finish();
  take();
  return live;
}

template <typename Event>
std::vector<Event> events_of(const std::vector<MapUpdate>& updates) {
  std::vector<Event> found;
  for (const MapUpdate& update : updates) {
    for (const MapEvent& event : update.events) {
      if (const auto* one = std::get_if<Event>(&event)) found.push_back(*one);
    }
  }
  return found;
}

/// Longest way from one update to the next in the odom frame, beyond what the robot went.
double longest_jump_m(const std::vector<MapUpdate>& updates, const std::vector<Pose2>& truth) {
  double longest = 0.0;
  for (std::size_t i = 1; i < updates.size(); ++i) {
    const Pose2 told = updates[i - 1].odom_T_robot.inverse() * updates[i].odom_T_robot;
    const Pose2 went = truth[i - 1].inverse() * truth[i];
    longest = std::max(longest, std::hypot(told.x - went.x, told.y - went.y));
  }
  return longest;
}

TEST(MapperLive, TellsEveryScanOnceInOrderAndWhereTheRobotIs) {
  const Live live = run(recording().messages);
  ASSERT_EQ(live.updates.size(), recording().truth.size());
  std::size_t keys = 0;
  for (std::size_t i = 0; i < live.updates.size(); ++i) {
    const MapUpdate& update = live.updates[i];
    EXPECT_EQ(update.scan, static_cast<std::int64_t>(i));
    EXPECT_EQ(update.stamp, stamp_of_scan(i));
    EXPECT_EQ(update.missed, 0);
    EXPECT_EQ(update.status, TrackingStatus::kTracked) << i;
    EXPECT_TRUE(pose_near(update.map_T_robot(), recording().truth[i], 0.25, 0.05)) << i;
    EXPECT_TRUE(update.covariance.allFinite());
    if (update.key_scan) {
      EXPECT_EQ(*update.key_scan, keys++);
    }
  }
  EXPECT_EQ(keys, static_cast<std::size_t>(live.result.statistics.key_scans));
  EXPECT_LT(longest_jump_m(live.updates, recording().truth), 0.03);
}

TEST(MapperLive, WhatTheFrontEndTellsIsTheSameForAnyNumberOfThreads) {
  const Live one = run(recording().messages, 1);
  const Live many = run(recording().messages, 4);
  ASSERT_EQ(one.updates.size(), many.updates.size());
  for (std::size_t i = 0; i < one.updates.size(); ++i) {
    ASSERT_EQ(one.updates[i].odom_T_robot, many.updates[i].odom_T_robot);
    ASSERT_EQ(one.updates[i].status, many.updates[i].status);
    ASSERT_EQ(one.updates[i].key_scan, many.updates[i].key_scan);
  }
  EXPECT_EQ(one.result.graph.poses, many.result.graph.poses);
}

TEST(MapperLive, AskingChangesNothing) {
  Mapper silent({}, {}, {2});
  for (const auto& message : recording().messages) silent.add(message);
  const MapResult unasked = silent.finish();
  Mapper mapper({}, {}, {2});
  LiveMap live({}, 0.2);
  for (const auto& message : recording().messages) {
    mapper.add(message);
    while (const auto update = mapper.next_update()) {
      if (update->scan % 20 == 0) live.refresh(mapper.snapshot());
    }
  }
  const MapResult asked = mapper.finish();
  EXPECT_EQ(asked.graph.poses, unasked.graph.poses);
  EXPECT_EQ(asked.map.log_odds.cells(), unasked.map.log_odds.cells());
}

TEST(MapperLive, SubmapsOpenFreezeAndCloseLoops) {
  // Twice round, so that closures are found while the robot still drives.
  auto points = kRoundAndAThird;
  points.insert(points.end(), {{12.4, 8.3}, {1.7, 8.4}, {1.6, 1.7}, {12.0, 1.6}});
  const Recording twice = drive(points, ring(), [](std::size_t) { return 1.0; });
  const Live live = run(twice.messages, 2, 50);
  const auto opened = events_of<SubmapOpened>(live.updates);
  const auto frozen = events_of<SubmapFrozen>(live.updates);
  ASSERT_GT(opened.size(), 5U);
  for (std::size_t i = 0; i < opened.size(); ++i) EXPECT_EQ(opened[i].id, SubmapId{i});
  for (std::size_t i = 0; i < frozen.size(); ++i) EXPECT_EQ(frozen[i].id, SubmapId{i});
  EXPECT_EQ(opened.size(), static_cast<std::size_t>(live.result.statistics.submaps));
  EXPECT_GE(opened.size(), frozen.size());
  const auto closures = events_of<ClosureChanged>(live.updates);
  const auto standing = std::count_if(closures.begin(), closures.end(),
                                      [](const auto& event) { return event.closure.stands(); });
  EXPECT_GT(standing, 0);
  for (const auto& event : closures) {
    if (!event.closure.stands()) continue;
    EXPECT_GT(event.closure.overlap, 0.3) << "with its evidence";
    EXPECT_GT(event.closure.agreement, 0.7);
  }
  const auto solved = events_of<GraphSolved>(live.updates);
  ASSERT_FALSE(solved.empty());
  EXPECT_GE(solved.back().largest_shift_m, solved.back().mean_shift_m);
  // A solution moves the map under the robot, and not the robot.
  EXPECT_NE(live.updates.back().map_T_odom, live.updates.front().map_T_odom);
  EXPECT_LT(longest_jump_m(live.updates, twice.truth), 0.03);
  EXPECT_TRUE(pose_near(live.updates.back().map_T_robot(), twice.truth.back(), 0.10, 0.03));
}

TEST(MapperLive, ARobotThatIsCarriedIsLostAndFoundAndItsOdometryFrameDoesNotJump) {
  Recording carried = recording();
  // In the middle of the first leg it is lifted 2 m ahead and 0.5 m aside: scans are of elsewhere.
  Recording elsewhere =
      drive(kRoundAndAThird, test::moved({2.0, 0.7, 0.0}, ring()), [](std::size_t) { return 1.0; });
  for (std::size_t i = 0; i < carried.messages.size(); ++i) {
    const bool later = stamp_of(carried.messages[i]) >= stamp_of_scan(40);
    if (later && std::holds_alternative<LaserScan>(carried.messages[i]))
      carried.messages[i] = elsewhere.messages[i];
  }
  const Live live = run(carried.messages);
  std::set<TrackingStatus> seen;
  for (const MapUpdate& update : live.updates) seen.insert(update.status);
  EXPECT_TRUE(seen.contains(TrackingStatus::kTracked));
  EXPECT_LT(longest_jump_m(live.updates, carried.truth), 0.2);
  double map_jump_m = 0.0;
  for (std::size_t i = 1; i < live.updates.size(); ++i) {
    const Pose2 moved = live.updates[i - 1].map_T_odom.inverse() * live.updates[i].map_T_odom;
    map_jump_m = std::max(map_jump_m, std::hypot(moved.x, moved.y));
  }
  EXPECT_GT(map_jump_m, 0.5) << "or the robot was never found again, and this tests nothing";
}

TEST(MapperLive, BlindScansAreBridgedByOdometryAndWithoutItLost) {
  const auto status_at_end = [](bool odometry) {
    std::vector<SensorMessage> messages;
    for (const auto& message : recording().messages) {
      if (stamp_of(message) > stamp_of_scan(70)) break;
      if (!odometry && !std::holds_alternative<LaserScan>(message)) continue;
      messages.push_back(message);
      auto* scan = std::get_if<LaserScan>(&messages.back());
      if (scan != nullptr && scan->stamp > stamp_of_scan(50))
        scan->ranges_m.assign(scan->ranges_m.size(), std::numeric_limits<float>::infinity());
    }
    return run(messages).updates.back().status;
  };
  EXPECT_EQ(status_at_end(true), TrackingStatus::kBridged);
  EXPECT_EQ(status_at_end(false), TrackingStatus::kLost) << "after two seconds without anything";
}

TEST(MapperLive, ACorridorIsDegenerateAlongItself) {
  const Walls corridor{{{-60.0, 0.0}, {60.0, 0.0}}, {{60.0, 2.0}, {-60.0, 2.0}}};
  const Recording along =
      drive({{-5.0, 1.0}, {5.0, 1.0}}, corridor, [](std::size_t) { return 1.0; });
  const Live live = run(along.messages);
  std::size_t degenerate = 0;
  for (const MapUpdate& update : live.updates) {
    if (update.status != TrackingStatus::kDegenerate) continue;
    ++degenerate;
    ASSERT_TRUE(update.open_direction_rad.has_value());
    EXPECT_LT(std::min(*update.open_direction_rad, kPi - *update.open_direction_rad), 0.05);
    EXPECT_GT(update.covariance(0, 0), 10.0 * update.covariance(1, 1));
  }
  EXPECT_GT(degenerate, live.updates.size() / 2);
}

TEST(MapperLive, OdometryThatGoesWrongAndComesRightIsTold) {
  // For a while the wheels spin: four times as far.
  auto points = kRoundAndAThird;
  const Recording spinning =
      drive(points, ring(), [](std::size_t i) { return i > 100 && i < 220 ? 4.0 : 1.0; });
  const Live live = run(spinning.messages);
  const auto faults = events_of<OdometryFaultChanged>(live.updates);
  ASSERT_GE(faults.size(), 2U);
  EXPECT_FALSE(faults.front().episode.over);
  EXPECT_TRUE(faults.back().episode.over);
}

TEST(MapperLive, UpdatesThatNobodyTakesAreGivenUpAndCounted) {
  Mapper mapper({}, {}, {1});
  Stamp stamp{1'000'000'000};
  const auto scan = std::get<LaserScan>(recording().messages[1]);
  constexpr std::int64_t kScans = 1200;
  for (std::int64_t i = 0; i < kScans; ++i) {
    stamp = stamp + Duration{kStepNs};
    mapper.add(OdometryPose{stamp, Pose2{}});
    LaserScan next = scan;
    next.stamp = stamp;
    mapper.add(next);
  }
  const auto first = mapper.next_update();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->scan, 200);
  EXPECT_EQ(first->missed, 200);
  std::int64_t taken = 1;
  while (const auto update = mapper.next_update()) {
    EXPECT_EQ(update->missed, 0);
    ++taken;
  }
  EXPECT_EQ(taken, 1000);
}

TEST(MapperLive, AScanWaitsForOdometryAQuarterOfASecondAtMost) {
  Mapper mapper({}, {}, {1});
  const auto& messages = recording().messages;
  mapper.add(messages[0]);
  mapper.add(messages[1]);
  ASSERT_TRUE(mapper.next_update().has_value()) << "odometry of its time is there";
  LaserScan scan = std::get<LaserScan>(messages[1]);
  const Stamp first = scan.stamp;
  int told = 0;
  for (int i = 1; i <= 30; ++i) {  // 100 a second, and odometry is silent
    scan.stamp = first + Duration{10'000'000LL * i};
    mapper.add(scan);
    while (const auto update = mapper.next_update()) {
      ++told;
      EXPECT_LE((scan.stamp - update->stamp).seconds(), 0.2501);
      EXPECT_GE((scan.stamp - update->stamp).seconds(), 0.2499);
    }
  }
  EXPECT_EQ(told, 5);
}

TEST(MapperLive, AScanThatComesLateGetsTheMotionOfItsOwnTime) {
  // Every scan two tenths of a second late; odometry runs ahead of it.
  std::vector<SensorMessage> late;
  std::vector<LaserScan> held;
  for (const auto& message : recording().messages) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      held.push_back(*scan);
      if (held.size() <= 2) continue;
      late.emplace_back(held.front());
      held.erase(held.begin());
    } else {
      late.push_back(message);
    }
  }
  for (const auto& scan : held) late.emplace_back(scan);
  const Live on_time = run(recording().messages);
  const Live delayed = run(late);
  ASSERT_EQ(on_time.updates.size(), delayed.updates.size());
  for (std::size_t i = 0; i < on_time.updates.size(); ++i) {
    EXPECT_TRUE(
        pose_near(on_time.updates[i].odom_T_robot, delayed.updates[i].odom_T_robot, 0.01, 0.005))
        << i;
  }
}

TEST(MapperLive, OptionsAreCheckedAtTheDoor) {
  MapOptions options;
  options.submap.cell_m = -1.0;
  options.front_end.odometry = static_cast<OdometryUse>(17);
  options.map.resolution_m = std::numeric_limits<double>::quiet_NaN();
  try {
    const Mapper mapper({}, options);
    FAIL() << "a mapper with these options can only be wrong";
  } catch (const OptionsError& error) {
    EXPECT_EQ(error.problems().size(), 3U) << error.what();
  }
}

TEST(MapperLive, CancelledBeforeItEndsItSaysSo) {
  std::stop_source stop;
  Mapper mapper({}, {}, {2});
  for (std::size_t i = 0; i < 200; ++i) mapper.add(recording().messages[i]);
  stop.request_stop();
  const MapResult result = mapper.finish({}, stop.get_token());
  EXPECT_FALSE(result.complete);
  EXPECT_FALSE(result.trajectory.empty());
  EXPECT_FALSE(result.map.log_odds.empty());
}

TEST(MapperSnapshot, IsConsistentAndCompleteWhileTheRobotDrives) {
  Mapper mapper({}, {}, {2});
  std::size_t newest = 0;
  for (const auto& message : recording().messages) {
    mapper.add(message);
    const MapSnapshot snapshot = mapper.snapshot();
    std::optional<std::size_t> last;
    for (std::size_t i = 0; i < snapshot.submaps.size(); ++i) {
      const SubmapSnapshot& submap = snapshot.submaps[i];
      EXPECT_EQ(submap.id, SubmapId{i});
      ASSERT_TRUE(submap.scans);
      ASSERT_FALSE(submap.scans->empty());
      EXPECT_TRUE(submap.scans->front()->is_key) << "a submap begins with a key scan";
      EXPECT_TRUE(pose_near(submap.map_T_local * submap.scans->front()->local_T_robot,
                            submap.map_T_submap, 1e-9, 1e-9));
      for (const auto& scan : *submap.scans) {
        EXPECT_TRUE(!last || scan->index > *last);
        last = scan->index;
      }
    }
    if (!last) continue;
    EXPECT_GE(*last, newest) << "what was handed over is never out of sight";
    newest = *last;
  }
  const MapSnapshot snapshot = mapper.snapshot();
  EXPECT_GT(newest, recording().truth.size() - 10);
  const auto keys = snapshot.key_scans();
  const MapResult result = mapper.finish();
  EXPECT_GE(keys.size(), result.node_stamps.size());
  for (const KeyScanSnapshot& key : keys) {
    EXPECT_TRUE(pose_near(*result.trajectory.at(key.stamp), key.map_T_robot, 0.25, 0.05));
  }
}

TEST(MapperSnapshot, DrawnItIsNearlyTheFinishedMap) {
  Mapper mapper({}, {}, {2});
  for (const auto& message : recording().messages) mapper.add(message);
  catch_up(mapper);
  LiveMap live({}, RobotModel{}.footprint_radius_m);
  live.refresh(mapper.snapshot());
  const OccupancyMap so_far = live.map();
  const OccupancyMap finished = mapper.finish().map;
  const auto state_of = [](float log_odds) {
    return log_odds > 0.6F ? 1 : (log_odds < 0.0F ? -1 : 0);
  };
  int compared = 0;
  int equal = 0;
  const GridFrame& frame = finished.log_odds.frame();
  for (std::size_t i = 0; i < frame.cell_count(); ++i) {
    const Cell cell{static_cast<int>(i) % frame.columns, static_cast<int>(i) / frame.columns};
    const Cell other = so_far.log_odds.frame().cell_of(frame.centre_of(cell));
    if (finished.observed[cell] == 0) continue;
    ++compared;
    if (!so_far.log_odds.frame().contains(other) || so_far.observed[other] == 0) continue;
    equal += state_of(finished.log_odds[cell]) == state_of(so_far.log_odds[other]) ? 1 : 0;
  }
  EXPECT_GT(compared, 20000);
  EXPECT_GT(equal, compared * 97 / 100) << equal << " of " << compared;
}

TEST(MapperSnapshot, CanBeTakenFromAnotherThread) {
  Mapper mapper({}, {}, {2});
  std::atomic<bool> driving{true};
  std::size_t taken = 0;
  std::thread viewer([&] {
    LiveMap live({}, 0.2);
    while (driving) {
      live.refresh(mapper.snapshot());
      ++taken;
    }
  });
  for (const auto& message : recording().messages) mapper.add(message);
  driving = false;
  viewer.join();
  EXPECT_GT(taken, 0U);
  EXPECT_GT(mapper.finish().statistics.scans, 0);
}

TEST(MapperSnapshot, GoesOnWithASessionThatWasResumed) {
  const auto& messages = recording().messages;
  Mapper first({}, {}, {1});
  for (std::size_t i = 0; i < messages.size() / 2; ++i) first.add(messages[i]);
  const auto state = first.save_state().get();
  const MapSnapshot before = first.snapshot();
  Mapper second({}, {}, {1});
  second.restore_state(state);
  const MapSnapshot after = second.snapshot();
  ASSERT_EQ(before.submaps.size(), after.submaps.size());
  for (std::size_t i = 0; i < before.submaps.size(); ++i) {
    EXPECT_EQ(before.submaps[i].map_T_submap, after.submaps[i].map_T_submap);
    EXPECT_EQ(before.submaps[i].scans->size(), after.submaps[i].scans->size());
    EXPECT_EQ(before.submaps[i].state, after.submaps[i].state);
  }
  while (first.next_update()) {
  }
  first.add(messages[messages.size() / 2]);
  second.add(messages[messages.size() / 2]);
  first.add(messages[messages.size() / 2 + 1]);
  second.add(messages[messages.size() / 2 + 1]);
  const auto a = first.next_update();
  const auto b = second.next_update();
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->odom_T_robot, b->odom_T_robot);
  EXPECT_EQ(a->map_T_odom, b->map_T_odom);
  EXPECT_EQ(a->key_scan, b->key_scan);
}

}  // namespace
}  // namespace loopstone
