#include "loopstone/mapping/travel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

constexpr double kRadiusM = 0.25;
const GridFrame kFrame{.origin = {-1.0, -2.0}, .resolution = 0.05, .columns = 240, .rows = 80};

/// A robot that goes from point to point at one speed, ten poses a second.
class Robot {
 public:
  explicit Robot(const Eigen::Vector2d& at) : at_(at) {
    path_.append(Stamp{}, {at.x(), at.y(), 0});
  }

  Robot& drive_to(const Eigen::Vector2d& to, double speed_m_s) {
    const Eigen::Vector2d way = to - at_;
    const int steps = static_cast<int>(std::lround(way.norm() / speed_m_s * 10.0));
    for (int i = 1; i <= steps; ++i) step(at_ + way * i / steps);
    at_ = to;
    return *this;
  }
  /// Poses have noise.
  Robot& stand(double seconds, double noise_m) {
    Rng rng(7);
    for (int i = 0; i < static_cast<int>(10.0 * seconds); ++i)
      step(at_ + Eigen::Vector2d(rng.normal(0.0, noise_m), rng.normal(0.0, noise_m)));
    return *this;
  }
  Robot& wait(double seconds) {
    time_s_ += seconds;
    return *this;
  }
  [[nodiscard]] const Trajectory& path() const { return path_; }

 private:
  void step(const Eigen::Vector2d& to) {
    time_s_ += 0.1;
    path_.append(Stamp::from_seconds(time_s_), {to.x(), to.y(), 0.0});
  }
  Eigen::Vector2d at_;
  double time_s_ = 0.0;
  Trajectory path_{};
};

CellTravel at(const Travel& travel, double x, double y) {
  return travel.cells()[kFrame.cell_of({x, y})];
}

TEST(Travel, TheFloorUnderTheFootprintIsDrivenAndNoOther) {
  Travel travel(kFrame);
  travel.add(Robot({0.0, 0.0}).drive_to({8.0, 0.7}, 0.5).path(), kRadiusM);
  const Eigen::Vector2d way(8.0, 0.7);
  for (int row = 0; row < kFrame.rows; ++row) {
    for (int column = 0; column < kFrame.columns; ++column) {
      const Eigen::Vector2d centre = kFrame.centre_of({column, row});
      const double share = std::clamp(centre.dot(way) / way.squaredNorm(), 0.0, 1.0);
      const double off = (centre - share * way).norm();
      if (std::abs(off - kRadiusM) < 1e-3) continue;
      EXPECT_EQ(travel.cells()[(Cell{column, row})].passes, off < kRadiusM ? 1 : 0) << centre;
    }
  }
}

TEST(Travel, SpeedsAreThoseOfThePassesEachCountedAlike) {
  Travel travel(kFrame);
  travel.add(Robot({0.0, 0.0}).drive_to({9.0, 0.0}, 0.4).drive_to({0.0, 0.0}, 0.8).path(),
             kRadiusM);
  travel.add(Robot({0.0, 0.0}).drive_to({9.0, 0.0}, 1.2).path(), kRadiusM);
  const CellTravel middle = at(travel, 4.0, 0.1);
  EXPECT_EQ(middle.passes, 3);
  EXPECT_NEAR(static_cast<double>(*middle.speed_m_s()), 0.8, 0.01);
  EXPECT_FALSE(at(travel, 4.0, 1.0).speed_m_s());
}

TEST(Travel, WhoTurnsBackNearbyCameByOnce) {
  Travel travel(kFrame);
  travel.add(Robot({0.0, 0.0}).drive_to({4.3, 0.0}, 0.5).drive_to({3.8, 0.0}, 0.5).path(),
             kRadiusM);
  EXPECT_EQ(at(travel, 3.9, 0.0).passes, 1);
  // From where it was long gone.
  EXPECT_EQ(at(travel, 0.0, 0.0).passes, 1);
  travel.add(Robot({0.0, 0.0}).drive_to({6.0, 0.0}, 0.5).drive_to({3.8, 0.0}, 0.5).path(),
             kRadiusM);
  EXPECT_EQ(at(travel, 3.9, 0.0).passes, 3);
}

TEST(Travel, StandingChangesNeitherPassesNorSpeeds) {
  Travel without(kFrame);
  Travel with(kFrame);
  without.add(Robot({0.0, 0.0}).drive_to({4.0, 0.0}, 0.5).drive_to({8.0, 0.0}, 0.5).path(),
              kRadiusM);
  with.add(Robot({0.0, 0.0})
               .drive_to({4.0, 0.0}, 0.5)
               .stand(300.0, 0.01)
               .drive_to({8.0, 0.0}, 0.5)
               .path(),
           kRadiusM);
  for (double x = 0.5; x < 8.0; x += 0.25) {
    EXPECT_EQ(at(with, x, 0.0).passes, at(without, x, 0.0).passes) << x;
    // Where it stopped and set off, both within the window.
    const double slower = std::abs(x - 4.0) < 2.0 * kRadiusM ? 0.25 : 0.02;
    EXPECT_NEAR(static_cast<double>(*at(with, x, 0.0).speed_m_s()), 0.5 - 0.5 * slower,
                0.5 * slower + 0.02)
        << x;
  }
}

TEST(Travel, WhoOnlyTurnedSomewhereHasNoSpeedThere) {
  Travel travel(kFrame);
  travel.add(Robot({1.0, 0.0}).stand(20.0, 0.0).path(), kRadiusM);
  EXPECT_EQ(at(travel, 1.1, 0.1).passes, 1);
  EXPECT_FALSE(at(travel, 1.1, 0.1).speed_m_s());
}

TEST(Travel, NothingIsKnownOfGaps) {
  Travel travel(kFrame);
  Trajectory path;
  path.append(Stamp::from_seconds(0.0), {0.0, 0.0, 0.0});
  path.append(Stamp::from_seconds(0.1), {0.05, 0.0, 0.0});
  path.append(Stamp::from_seconds(0.2), {3.0, 0.0, 0.0});   // carried
  path.append(Stamp::from_seconds(60.0), {3.9, 0.0, 0.0});  // nobody looked
  travel.add(path, kRadiusM);
  EXPECT_EQ(at(travel, 0.0, 0.0).passes, 1);
  EXPECT_EQ(at(travel, 1.5, 0.0).passes, 0);
  EXPECT_EQ(at(travel, 3.0, 0.0).passes, 1);
  EXPECT_EQ(at(travel, 3.45, 0.0).passes, 0);
}

TEST(Travel, ARobotWithoutASizeStillTouchesEachCellOfItsPath) {
  Travel travel(kFrame);
  travel.add(Robot({0.0, 0.0}).drive_to({5.0, 1.7}, 0.5).path(), 0.0);
  for (double share = 0.0; share <= 1.0; share += 0.001)
    EXPECT_EQ(at(travel, 5.0 * share, 1.7 * share).passes, 1) << share;
}

TEST(Travel, WhatLiesBeyondTheFrameIsLeftOut) {
  Travel travel(kFrame);
  travel.add(Robot({-5.0, 0.0}).drive_to({50.0, 0.0}, 1.0).path(), kRadiusM);
  EXPECT_EQ(at(travel, 10.9, 0.0).passes, 1);
  travel.add(Trajectory{}, kRadiusM);
}

}  // namespace
}  // namespace loopstone
