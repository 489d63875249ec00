#include "mapping/visit_contradictions.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace loopstone {
namespace {

/// Stretches of 10 s.
StretchTimes times_of(int stretches) {
  StretchTimes times;
  for (int i = 0; i < stretches; ++i)
    times.emplace_back(Stamp::from_seconds(10.0 * i), Stamp::from_seconds(10.0 * i + 9.0));
  return times;
}

/// Beams of a visit meet a straight wall of another, four a place of 50 cm.
std::vector<BeamMeeting> meetings(float from_x, float to_x, int wall, int beam, float behind_m) {
  std::vector<BeamMeeting> met;
  for (float x = from_x; x < to_x; x += 0.125F) {
    met.push_back({.where = {x, 1.0F},
                   .crossed = behind_m > 0.0F ? 0 : -1,
                   .behind_m = behind_m,
                   .stretch = beam,
                   .wall_stretch = wall});
  }
  return met;
}

TEST(VisitContradictions, TellPlaceVisitsAndSize) {
  const auto found = visit_contradictions({}, meetings(4.0F, 12.0F, 2, 20, 1.5F), times_of(30));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].wall_m, 8.0, 0.51);
  EXPECT_NEAR(found[0].apart_m, 1.5, 1e-6);
  EXPECT_EQ(found[0].share, 1.0);
  EXPECT_NEAR(found[0].centre().x(), 8.0, 0.3);
  EXPECT_EQ(found[0].first_from, Stamp::from_seconds(20.0));
  EXPECT_EQ(found[0].first_to, Stamp::from_seconds(29.0));
  EXPECT_EQ(found[0].second_from, Stamp::from_seconds(200.0));
}

TEST(VisitContradictions, OfOneVisitAmongManyThatAgreeIsFound) {
  auto met = meetings(0.0F, 6.0F, 2, 40, 4.3F);
  for (int visit = 8; visit < 30; ++visit) {
    const auto agree = meetings(0.0F, 6.0F, 2, visit, 0.0F);
    met.insert(met.end(), agree.begin(), agree.end());
  }
  const auto found = visit_contradictions({}, met, times_of(50));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GT(found[0].share, 0.9) << "of what these two visits say, not of what all say";
}

TEST(VisitContradictions, ADoorIsASmallShareOfWhatTwoVisitsSay) {
  auto met = meetings(0.0F, 14.0F, 2, 20, 0.0F);
  const auto door = meetings(14.0F, 15.5F, 2, 20, 3.0F);
  met.insert(met.end(), door.begin(), door.end());
  const auto found = visit_contradictions({}, met, times_of(30));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT(found[0].wall_m, 2.1);
  EXPECT_LT(found[0].share, 0.2);
}

TEST(VisitContradictions, WallsThatLieNearBothWaysDoNotContradict) {
  std::vector<WallOffset> offsets;
  const auto add = [&](float offset_m) {
    for (float x = 0.0F; x < 6.0F; x += 0.1F)
      offsets.push_back({{x, 0.0F}, offset_m, Eigen::Vector2f::UnitY(), 1, 15});
  };
  add(0.2F);
  EXPECT_TRUE(visit_contradictions(offsets, {}, times_of(20)).empty());
  offsets.clear();
  add(0.4F);
  const auto found = visit_contradictions(offsets, {}, times_of(20));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].apart_m, 0.4, 1e-6);
}

TEST(AgreeingVisits, NeedTwoDirectionsAndSomeWay) {
  std::vector<WallOffset> corridor;
  for (float x = 0.0F; x < 8.0F; x += 0.1F)
    corridor.push_back({{x, 0.0F}, 0.02F, Eigen::Vector2f::UnitY(), 1, 15});
  EXPECT_TRUE(agreeing_visits(corridor, {}, times_of(20)).empty()) << "it may slide along";
  std::vector<WallOffset> corner = corridor;
  for (float y = 0.0F; y < 4.0F; y += 0.1F)
    corner.push_back({{0.0F, y}, 0.02F, Eigen::Vector2f::UnitX(), 1, 15});
  const auto ties = agreeing_visits(corner, {}, times_of(20));
  ASSERT_EQ(ties.size(), 1U);
  EXPECT_LT(ties[0].first, Stamp::from_seconds(20.0));
  EXPECT_GE(ties[0].second, Stamp::from_seconds(150.0));
  for (WallOffset& offset : corner) offset.other_stretch = 5;
  EXPECT_TRUE(agreeing_visits(corner, {}, times_of(20)).empty())
      << "the path has had no time to drift";
}

TEST(StretchTimes, OfAStretchWithoutScansAreThoseBefore) {
  std::vector<JudgedScan> scans(3);
  scans[0].stamp = Stamp{1};
  scans[1] = {.stretch = 0, .stamp = Stamp{5}};
  scans[2] = {.stretch = 2, .stamp = Stamp{9}};
  const StretchTimes times = stretch_times(scans);
  ASSERT_EQ(times.size(), 3U);
  EXPECT_EQ(times[0], (std::pair{Stamp{1}, Stamp{5}}));
  EXPECT_EQ(times[1], times[0]);
  EXPECT_EQ(times[2], (std::pair{Stamp{9}, Stamp{9}}));
}

}  // namespace
}  // namespace loopstone
