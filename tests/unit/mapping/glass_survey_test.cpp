#include "loopstone/mapping/glass_survey.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "simulation/beam_path.hpp"

namespace loopstone {
namespace {

const GridFrame kFrame{.origin = {-10.0, -5.0}, .resolution = 0.05, .columns = 400, .rows = 220};
/// A wall of glass at y = 1.5, seen from below, with a wall behind it and another one before it.
constexpr double kGlassY = 1.5;
constexpr double kGlassThicknessM = 0.1;

FloorPlan corridor() {
  FloorPlan plan;
  plan.boxes.push_back(
      {{0.0, kGlassY + 0.5 * kGlassThicknessM, 0.0}, 12.0, kGlassThicknessM, true});
  plan.boxes.push_back({{0.0, 3.6, 0.0}, 16.0, 0.2, false});
  plan.boxes.push_back({{0.0, -1.6, 0.0}, 16.0, 0.2, false});
  return plan;
}

Realism with_glass() {
  Realism realism;
  realism.glass.on = true;
  realism.glass.share = 1.0;
  return realism;
}

/// Scans of a robot that drives from x = -6 m to 6 m.
class Scans {
 public:
  explicit Scans(const std::function<double(double x_m, const Eigen::Vector2d& origin,
                                            const Eigen::Vector2d& direction)>& range) {
    Rng rng(5);
    for (double x = -6.0; x <= 6.0; x += 0.1) {
      LaserScan scan{.stamp = Stamp::from_seconds(2.0 * x + 100.0),
                     .angle_min_rad = -0.75 * kPi,
                     .angle_increment_rad = 1.5 * kPi / 540.0,
                     .range_min_m = 0.1,
                     .range_max_m = 20.0};
      for (std::size_t i = 0; i <= 540; ++i) {
        const double angle = scan.angle_rad(i);
        const double met = range(x, {x, 0.0}, {std::cos(angle), std::sin(angle)});
        scan.ranges_m.push_back(static_cast<float>(met + rng.normal(0.0, 0.01)));
      }
      scans_.push_back(std::move(scan));
    }
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      const Pose2 pose{-6.0 + 0.1 * static_cast<double>(i), 0.0, 0.0};
      posed_.push_back({&scans_[i], pose, pose, pose});
    }
  }
  [[nodiscard]] const std::vector<PosedScan>& posed() const { return posed_; }

 private:
  std::vector<LaserScan> scans_{};
  std::vector<PosedScan> posed_{};
};

Scans scans_in(const FloorPlan& plan, const Realism& realism) {
  const SurfaceIndex surfaces(plan);
  const BeamPath path(plan, realism, 1);
  return Scans([&](double, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) {
    return path.follow(surfaces, origin, direction, 20.0, {}).range_m;
  });
}

Grid<float> surveyed(const std::vector<const Scans*>& drives, Threads threads = {1}) {
  GlassSurvey survey;
  for (const Scans* drive : drives) survey.add(drive->posed(), 0.25, threads);
  return survey.probability(kFrame);
}

float greatest(const Grid<float>& probability) {
  return *std::ranges::max_element(probability.cells());
}

TEST(GlassSurvey, AWallOfGlassIsFoundAlongItsLengthAndTheOthersAreNot) {
  const Scans scans = scans_in(corridor(), with_glass());
  const Grid<float> glass = surveyed({&scans});
  int found = 0;
  for (double x = -4.5; x <= 4.5; x += 0.1) {
    float most = -1.0F;
    for (const double off : {-0.05, 0.0, 0.05})
      most = std::max(most, glass[kFrame.cell_of({x, kGlassY + off})]);
    found += most > 0.9F ? 1 : 0;
  }
  EXPECT_GT(found, 80);  // of 91
  for (int row = 0; row < kFrame.rows; ++row) {
    for (int column = 0; column < kFrame.columns; ++column) {
      const Eigen::Vector2d at = kFrame.centre_of({column, row});
      if (std::abs(at.y() - kGlassY) > 0.15) {
        EXPECT_LT(glass[(Cell{column, row})], 0.5F) << at;
      }
    }
  }
  double length_m = 0.0;
  for (const GlassPane& pane : suspected_panes(glass)) {
    length_m += pane.length_m();
    EXPECT_NEAR(pane.low.y(), kGlassY, 0.1);
    EXPECT_NEAR(pane.high.y(), kGlassY, 0.1);
    EXPECT_GE(pane.length_m(), kGlassSurvey.least_pane_m);
    EXPECT_GE(pane.probability, kGlassSurvey.sure);
  }
  EXPECT_NEAR(length_m, 10.5, 1.5);
}

TEST(GlassSurvey, TheSameWallsWithoutGlassAreSolid) {
  const Scans scans = scans_in(corridor(), Realism{});
  const Grid<float> glass = surveyed({&scans});
  EXPECT_LT(greatest(glass), 0.1F);
  EXPECT_GE(greatest(glass), 0.0F);  // they were looked at
}

TEST(GlassSurvey, AWallThatWentAwayIsNotGlass) {
  const SurfaceIndex before(corridor());
  FloorPlan without = corridor();
  without.boxes.erase(without.boxes.begin());
  const SurfaceIndex after(without);
  for (const double gone_at_x : {-3.0, 0.0, 3.0}) {
    const Scans scans(
        [&](double x, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) {
          return (x < gone_at_x ? before : after).cast(origin, direction, 20.0);
        });
    EXPECT_LT(greatest(surveyed({&scans})), 0.5F) << gone_at_x;
  }
}

TEST(GlassSurvey, WhereTheRobotDroveNothingStands) {
  // The panes stand where it drives, as people do who step aside.
  FloorPlan plan = corridor();
  plan.boxes.front().map_T_box.y = 0.2;
  const SurfaceIndex surfaces(plan);
  const BeamPath path(plan, with_glass(), 1);
  const Scans scans([&](double, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) {
    const Eigen::Vector2d below = origin - Eigen::Vector2d(0.0, 0.8);
    return path.follow(surfaces, below, direction, 20.0, {}).range_m;
  });
  std::vector<PosedScan> lower = scans.posed();
  for (PosedScan& posed : lower)
    for (Pose2* pose : {&posed.map_T_lidar, &posed.map_T_lidar_end}) pose->y -= 0.8;
  GlassSurvey survey;
  survey.add(lower, 0.25);
  EXPECT_LT(greatest(survey.probability(kFrame)), 0.5F);
  survey = {};
  survey.add(lower, 0.05);
  EXPECT_GT(greatest(survey.probability(kFrame)), 0.9F);
}

TEST(GlassSurvey, VisitsThatFoundItSolidOutvoteOneThatDidNot) {
  const Scans glassy = scans_in(corridor(), with_glass());
  const Scans solid = scans_in(corridor(), Realism{});
  EXPECT_GT(greatest(surveyed({&glassy, &glassy})), 0.9F);
  EXPECT_LT(greatest(surveyed({&glassy, &solid, &solid})), 0.5F);
  // In any order.
  EXPECT_EQ(surveyed({&glassy, &solid, &solid}).cells(),
            surveyed({&solid, &solid, &glassy}).cells());
}

TEST(GlassSurvey, ThreadsChangeNothing) {
  const Scans scans = scans_in(corridor(), with_glass());
  EXPECT_EQ(surveyed({&scans}, {1}).cells(), surveyed({&scans}, {4}).cells());
}

TEST(GlassSurvey, NothingSeenIsNothingKnown) {
  GlassSurvey survey;
  survey.add({}, 0.25);
  EXPECT_EQ(greatest(survey.probability(kFrame)), -1.0F);
  EXPECT_TRUE(suspected_panes(survey.probability(kFrame)).empty());
}

}  // namespace
}  // namespace loopstone
