#include "loopstone/slam/loop_closer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

#include "loop_scene.hpp"
#include "loopstone/geometry/angle.hpp"
#include "slam/scan_edges.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::empty_submap;
using test::pose_near;
using test::submap_seen_from;
using test::Walls;

const std::vector<Pose2> kFirstVisit{
    {4.0, 3.0, 0.0}, {4.6, 3.2, 0.8}, {5.2, 3.8, 2.0}, {3.2, 2.5, -2.0}};
const std::vector<Pose2> kSecondVisit{
    {3.4, 2.2, 1.7}, {3.3, 3.0, 2.6}, {2.6, 2.4, -1.0}, {4.6, 2.8, 0.2}};

/// A closer and the submaps that it is asked about.
struct Scene {
  LoopCloser closer;
  std::vector<SubmapRecord> submaps{};

  explicit Scene(const LoopOptions& options = {}, Threads threads = {1})
      : closer(options, {}, {}, threads) {}
  void add(FinishedSubmap submap, double travelled_m) {
    SubmapRecord& record = submaps.emplace_back();
    record.freeze(std::move(submap));
    record.travelled_m = travelled_m;
  }
  void place(const std::vector<Pose2>& map_T_submap) {
    for (std::size_t i = 0; i < submaps.size(); ++i) submaps[i].map_T_submap = map_T_submap[i];
  }
  [[nodiscard]] std::vector<LoopClosure> close_newest(const std::vector<Pose2>& map_T_submap) {
    place(map_T_submap);
    return closer.close_newest(submaps);
  }
  [[nodiscard]] std::vector<LoopClosure> close_all(const std::vector<Pose2>& map_T_submap) {
    place(map_T_submap);
    return closer.close_all(submaps);
  }
  void set_closures(const std::vector<LoopClosure>& closures) {
    closer.set_closures(submaps, closures);
  }
  std::vector<SubmapId> drop_covered() { return closer.drop_covered(submaps); }
};

/// Five submaps, 15 m of travel apart; the last one is of the place of the first one, and the
/// others saw nothing.
Scene closer_with(FinishedSubmap first, FinishedSubmap last, Threads threads = {1},
                  double leg_m = 15.0) {
  Scene closer({}, threads);
  closer.add(std::move(first), 0.0);
  for (std::size_t key = 1; key < 4; ++key)
    closer.add(empty_submap(key), leg_m * static_cast<double>(key));
  closer.add(std::move(last), 4.0 * leg_m);
  return closer;
}

std::vector<Pose2> submap_poses(const Pose2& last) {
  return {kFirstVisit.front(), {20.0, 0.0, 0.0}, {30.0, 10.0, 1.0}, {20.0, 10.0, 2.0}, last};
}

/// Right after a break the robot stands beside where it was, and may have turned any way.
TEST(LoopCloser, BesideABreakThePlaceIsFoundWhicheverWayTheRobotFaces) {
  const Pose2 truth = kFirstVisit.front().inverse() * kSecondVisit.front();
  const auto found_with = [&](double sigma_rad, double turned_rad) {
    Scene scene;
    scene.add(submap_seen_from(test::furnished_room(), kFirstVisit, 0), 0.0);
    FinishedSubmap after = submap_seen_from(test::furnished_room(), kSecondVisit, 1);
    after.piece = 1;
    scene.add(std::move(after), 4.0);
    KeyScan first;
    first.across = planar_covariance(0.8, sigma_rad);
    scene.submaps[1].keys = {first};
    return scene.close_newest(
        {kFirstVisit.front(), kSecondVisit.front() * Pose2{0.3, -0.4, turned_rad}});
  };
  for (const double turned_rad : {-2.8, -1.5, 0.5, 1.7, 3.0}) {
    const auto closures = found_with(1.6, turned_rad);
    ASSERT_EQ(closures.size(), 1U) << turned_rad;
    EXPECT_FALSE(closures[0].by_appearance);
    EXPECT_TRUE(pose_near(closures[0].from_T_to, truth, 0.02, 0.006)) << turned_rad;
  }
  // Where the path knows the heading, nothing else is looked for.
  for (const LoopClosure& closure : found_with(0.05, 3.0))
    EXPECT_TRUE(closure.by_appearance ||
                std::abs(wrap_angle(closure.from_T_to.yaw - truth.yaw)) > 0.5);
}

TEST(LoopCloser, FindsAPlaceSeenFromElsewhereDespiteDrift) {
  const Pose2 truth = kFirstVisit.front().inverse() * kSecondVisit.front();
  for (const Pose2& drift : {Pose2{}, Pose2{0.8, -0.6, 0.15}, Pose2{-1.2, 0.5, -0.2}}) {
    auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                              submap_seen_from(test::furnished_room(), kSecondVisit, 4));
    const auto closures = closer.close_newest(submap_poses(kSecondVisit.front() * drift));
    ASSERT_EQ(closures.size(), 1U);
    const auto& closure = closures.front();
    EXPECT_EQ(closure.state, ClosureState::kWaiting) << to_string(closure.reason);
    EXPECT_FALSE(closure.by_appearance);
    EXPECT_EQ(closure.from, NodeId{0});
    EXPECT_EQ(closure.to, NodeId{4});
    EXPECT_EQ(closure.from_submap, SubmapId{0});
    EXPECT_EQ(closure.to_submap, SubmapId{4});
    EXPECT_TRUE(pose_near(closure.from_T_to, truth, 0.02, 0.006));
    EXPECT_GT(closure.overlap, 0.7);
    EXPECT_GT(closure.agreement, 0.8);
    EXPECT_FALSE(closure.second_score);
  }
}

TEST(LoopCloser, SaysThatAPlaceLooksTheSameElsewhere) {
  // A hall with a column every 1.5 m: each looks like the next.
  Walls hall{{{-60.0, 0.0}, {60.0, 0.0}}, {{60.0, 4.0}, {-60.0, 4.0}}};
  for (double x = -60.0; x < 60.0; x += 1.5) {
    hall = test::together({hall, test::rectangle({x, 0.0}, {x + 0.4, 0.4}),
                           test::rectangle({x, 3.6}, {x + 0.4, 4.0})});
  }
  const test::Scanner scanner{.angle_min_rad = -kPi, .beams = 720, .range_max_m = 12.0};
  const std::vector<Pose2> there{
      {0.0, 2.0, 0.0}, {1.0, 2.0, 0.0}, {2.0, 2.0, 0.0}, {3.0, 2.0, 0.0}};
  const std::vector<Pose2> back{{3.0, 2.2, kPi}, {2.0, 2.2, kPi}, {1.0, 2.2, kPi}, {0.0, 2.2, kPi}};
  auto closer = closer_with(submap_seen_from(hall, there, 0, scanner),
                            submap_seen_from(hall, back, 4, scanner));
  auto poses = submap_poses(back.front());
  poses.front() = there.front();
  const auto closures = closer.close_newest(poses);
  ASSERT_EQ(closures.size(), 1U);
  EXPECT_EQ(closures.front().state, ClosureState::kWaiting) << "the path may know which it is";
  ASSERT_TRUE(closures.front().second_score);
  EXPECT_GT(*closures.front().second_score, 0.85 * closures.front().score);
}

TEST(LoopCloser, RefusesAnotherPlaceWhereTheFirstShouldBe) {
  const Walls other = test::together(
      {test::rectangle({0.0, 0.5}, {5.0, 8.0}), test::rectangle({1.0, 3.5}, {2.2, 4.1}),
       test::rectangle({3.4, 1.0}, {4.1, 1.4}), test::rectangle({2.0, 6.0}, {4.9, 6.3})});
  auto closer =
      closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                  submap_seen_from(other, {{3.0, 2.5, 1.7}, {3.0, 3.2, 2.6}, {2.6, 2.4, -1.0}}, 4));
  for (const auto& closure : closer.close_newest(submap_poses(kSecondVisit.front()))) {
    EXPECT_EQ(closure.state, ClosureState::kRejected)
        << "score " << closure.score << ", agreement " << closure.agreement;
    EXPECT_NE(closure.reason, ClosureReason::kNone);
  }
}

TEST(LoopCloser, LooksNoFartherThanTheDriftExplains) {
  // 1 m of travel a leg: the poses can't be 3 m wrong.
  auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                            submap_seen_from(test::furnished_room(), kSecondVisit, 4), {1}, 1.0);
  for (const auto& closure :
       closer.close_newest(submap_poses(kSecondVisit.front() * Pose2{3.0, 0.0, 0.0}))) {
    EXPECT_EQ(closure.state, ClosureState::kRejected);
  }
  EXPECT_TRUE(closer.close_newest(submap_poses({500.0, 0.0, 0.0})).empty());
}

TEST(LoopCloser, FindsAPlaceByItsLooksWhereThePoseIsFarOff) {
  // 2 km of travel: the pose may be 60 m wrong, and the heading anything.
  const Pose2 far_off = Pose2{37.0, -15.0, 0.0} * kSecondVisit.front() * Pose2{0.0, 0.0, 2.5};
  auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                            submap_seen_from(test::furnished_room(), kSecondVisit, 4), {1}, 500.0);
  const auto closures = closer.close_newest(submap_poses(far_off));
  ASSERT_EQ(closures.size(), 1U);
  EXPECT_EQ(closures.front().state, ClosureState::kWaiting) << to_string(closures.front().reason);
  EXPECT_TRUE(closures.front().by_appearance);
  EXPECT_TRUE(pose_near(closures.front().from_T_to,
                        kFirstVisit.front().inverse() * kSecondVisit.front(), 0.02, 0.006));
  EXPECT_TRUE(closer.close_newest(submap_poses(far_off * Pose2{5.0, 0.0, 1.0})).empty())
      << "whatever the pose, it would say the same again";
}

TEST(LoopCloser, APairTriedByAppearanceAndFoundByItsPoseLaterHasAPoseThatVouches) {
  const Pose2 far_off = Pose2{37.0, -15.0, 0.0} * kSecondVisit.front() * Pose2{0.0, 0.0, 2.5};
  auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                            submap_seen_from(test::furnished_room(), kSecondVisit, 4), {1}, 500.0);
  const auto first = closer.close_newest(submap_poses(far_off));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_TRUE(first.front().by_appearance);
  // Other closures have moved the path: now its pose says that it is there.
  const auto second = closer.close_newest(submap_poses(kSecondVisit.front()));
  ASSERT_EQ(second.size(), 1U);
  EXPECT_FALSE(second.front().by_appearance);
  EXPECT_EQ(second.front().from_submap, first.front().from_submap);
}

TEST(LoopCloser, LooksForPlacesOnlyWhereTheDriftCallsForIt) {
  const auto found = [](double leg_m, const Pose2& pose, int places_max) {
    Scene closer({.places_max = places_max});
    closer.add(submap_seen_from(test::furnished_room(), kFirstVisit, 0), 0.0);
    for (std::size_t key = 1; key < 4; ++key)
      closer.add(empty_submap(key), leg_m * static_cast<double>(key));
    closer.add(submap_seen_from(test::furnished_room(), kSecondVisit, 4), 4.0 * leg_m);
    return closer.close_newest(submap_poses(pose)).size();
  };
  EXPECT_EQ(found(500.0, {40.0, 0.0, 0.0}, 3), 1U);
  EXPECT_EQ(found(500.0, {40.0, 0.0, 0.0}, 0), 0U) << "switched off";
  EXPECT_EQ(found(60.0, {40.0, 0.0, 0.0}, 3), 0U) << "240 m: the window holds what drift explains";
  EXPECT_EQ(found(500.0, {100.0, 0.0, 0.0}, 3), 0U) << "farther than drift explains";
}

TEST(LoopCloser, RefusesAnotherPlaceThatIsTriedForItsLooks) {
  const Walls other = test::together(
      {test::rectangle({0.0, 0.5}, {5.0, 8.0}), test::rectangle({1.0, 3.5}, {2.2, 4.1}),
       test::rectangle({3.4, 1.0}, {4.1, 1.4}), test::rectangle({2.0, 6.0}, {4.9, 6.3})});
  auto closer = closer_with(
      submap_seen_from(test::furnished_room(), kFirstVisit, 0),
      submap_seen_from(other, {{3.0, 2.5, 1.7}, {3.0, 3.2, 2.6}, {2.6, 2.4, -1.0}}, 4), {1}, 500.0);
  for (const auto& closure : closer.close_newest(submap_poses({40.0, 0.0, 0.0})))
    EXPECT_EQ(closure.state, ClosureState::kRejected) << closure.score << ' ' << closure.agreement;
}

TEST(LoopCloser, RefusesAPlaceThatIsThereTwice) {
  // The same room at two places: nobody can tell which one this is.
  Scene closer;
  const auto room = submap_seen_from(test::furnished_room(), kFirstVisit, 0);
  closer.add(room, 0.0);
  closer.add(empty_submap(1), 200.0);
  closer.add(room, 400.0);
  for (std::size_t key = 3; key < 6; ++key)
    closer.add(empty_submap(key), 400.0 * static_cast<double>(key));
  closer.add(submap_seen_from(test::furnished_room(), kSecondVisit, 6), 2400.0);
  const std::vector<Pose2> poses{{0.0, 0.0, 0.0},  {50.0, 0.0, 0.0}, {30.0, 0.0, 0.0},
                                 {50.0, 9.0, 0.0}, {50.0, 0.0, 0.0}, {50.0, 5.0, 0.0},
                                 {15.0, 35.0, 0.0}};
  const auto closures = closer.close_newest(poses);
  ASSERT_EQ(closures.size(), 2U);
  for (const auto& closure : closures) {
    EXPECT_EQ(closure.state, ClosureState::kRejected);
    EXPECT_EQ(closure.reason, ClosureReason::kAmbiguousPlace);
  }
}

TEST(LoopCloser, ThreadsDoNotChangeTheAnswer) {
  const auto run = [](int threads) {
    auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                              submap_seen_from(test::furnished_room(), kSecondVisit, 4), {threads});
    return closer.close_all(submap_poses(kSecondVisit.front() * Pose2{0.3, 0.2, 0.1}));
  };
  const auto one = run(1);
  const auto many = run(4);
  ASSERT_EQ(one.size(), many.size());
  ASSERT_FALSE(one.empty());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].from_T_to, many[i].from_T_to);
    EXPECT_EQ(one[i].covariance, many[i].covariance);
    EXPECT_EQ(one[i].score, many[i].score);
    EXPECT_EQ(one[i].state, many[i].state);
  }
}

TEST(LoopCloser, AStandingClosureIsNotTriedAgain) {
  auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0),
                            submap_seen_from(test::furnished_room(), kSecondVisit, 4));
  const auto poses = submap_poses(kSecondVisit.front());
  auto closures = closer.close_newest(poses);
  ASSERT_EQ(closures.size(), 1U);
  closures.front().state = ClosureState::kStanding;
  closer.set_closures(closures);
  EXPECT_TRUE(closer.close_all(poses).empty());
}

TEST(LoopCloser, DropsASubmapThatOlderOnesSawAndNoOther) {
  const auto dropped_after = [](const FinishedSubmap& second, bool stands) {
    auto closer = closer_with(submap_seen_from(test::furnished_room(), kFirstVisit, 0), second);
    auto poses = submap_poses(kSecondVisit.front());
    auto closures = closer.close_newest(poses);
    EXPECT_EQ(closures.size(), 1U);
    for (auto& closure : closures)
      if (stands) closure.state = ClosureState::kStanding;
    closer.set_closures(closures);
    const auto dropped = closer.drop_covered();
    EXPECT_TRUE(closer.drop_covered().empty()) << "each is named once";
    // Whoever comes now finds the older one, and nothing of what was dropped.
    for (std::size_t i = 0; i < 3; ++i) {
      closer.add(i < 2 ? empty_submap(5 + i) : second, 75.0 + 15.0 * static_cast<double>(i));
      poses.push_back(kSecondVisit.front());
    }
    bool found_second = false;
    for (const auto& closure : closer.close_newest(poses))
      found_second = found_second || closure.from_submap == SubmapId{4};
    EXPECT_EQ(found_second, dropped.empty());
    return dropped;
  };
  const auto again = submap_seen_from(test::furnished_room(), kSecondVisit, 4);
  EXPECT_EQ(dropped_after(again, true), std::vector<SubmapId>{{4}});
  EXPECT_TRUE(dropped_after(again, false).empty()) << "it may be another place";
  // The room next door was not seen before.
  const Walls both =
      test::together({test::furnished_room(), test::rectangle({15.0, 0.0}, {27.0, 9.0})});
  auto poses = kSecondVisit;
  poses.insert(poses.end(), {{18.0, 3.0, 0.0}, {22.0, 5.0, 3.0}});
  EXPECT_TRUE(dropped_after(submap_seen_from(both, poses, 4), true).empty());
}

TEST(LoopCloser, EdgeCarriesTheCovarianceIntoTheFrameOfTheGraphsError) {
  LoopClosure closure;
  closure.from = NodeId{0};
  closure.to = NodeId{1};
  closure.from_T_to = {2.0, 1.0, 0.9};
  closure.covariance =
      (Eigen::Matrix3d() << 0.04, 0.01, 0.001, 0.01, 0.01, 0.0, 0.001, 0.0, 0.0025).finished();
  const auto edge = edge_of(closure);
  EXPECT_EQ(edge.kind, EdgeKind::kLoopClosure);
  // An error d of from_T_to, in its own coordinates, must cost d^T C^-1 d wherever the two poses
  // are.
  const Eigen::Vector3d d(0.02, -0.03, 0.01);
  const Pose2 from{-3.0, 5.0, -2.0};
  const Pose2 off{closure.from_T_to.x + d.x(), closure.from_T_to.y + d.y(),
                  closure.from_T_to.yaw + d.z()};
  EXPECT_NEAR(edge_chi2(edge, from, from * off), d.dot(closure.covariance.inverse() * d), 1e-9);
  EXPECT_NEAR(edge_chi2(edge, from, from * closure.from_T_to), 0.0, 1e-12);
}

TEST(LoopCloser, AMemoryOfSubmapsThatAreNotThereIsNotSound) {
  const std::vector<SubmapRecord> one(1);
  const auto sound = [&](const LoopCloser::State& state) { return is_sound(state, one); };
  EXPECT_TRUE(sound({}));
  EXPECT_TRUE(sound({.newly_closed = {{0}}}));
  EXPECT_FALSE(sound({.standing = {{{1}, {0}}}}));
  EXPECT_FALSE(sound({.tried = {{{{0}, {1}}, Pose2{}}}}));
  EXPECT_FALSE(sound({.tried_by_appearance = {{{1}, {0}}}}));
  EXPECT_FALSE(sound({.newly_closed = {{1}}}));
  EXPECT_TRUE(sound({.seen = {{{{0}, {0}}, {}}}}));
  EXPECT_FALSE(sound({.seen = {{{{0}, {0}}, {true}}}})) << "of a surface that is not there";
}

}  // namespace
}  // namespace loopstone
