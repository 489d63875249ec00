// Panes of glass in simulated buildings: those that are suspected, held against what walls are made
// of.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/mapping/glass_survey.hpp"
#include "loopstone/mapping/visit_ledger.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/joined_drives.hpp"
#include "loopstone/slam/mapper.hpp"
#include "simulation/beam_path.hpp"
#include "support/test_scale.hpp"
#include "support/usual_figure.hpp"

namespace loopstone {
namespace {

constexpr double kReachM = 30.0;

/// A drive as it was mapped by itself, and its truth in the frame of the building.
struct GlassDrive {
  World world{};
  Realism realism{};
  Trajectory truth{};
  std::shared_ptr<const DriveRecord> record{};
};

/// \param start  of the world's places; the seed of the drive, too
GlassDrive driven(std::string_view name, std::uint64_t seed, const std::string& effects,
                  std::size_t start = 0) {
  GlassDrive drive;
  choose_realism(drive.realism, effects);
  RealismRecord record;
  drive.world = real_world(make_world(name, seed), drive.realism, seed, record);
  if (start > 0) {
    const Eigen::Vector2d from = drive.world.places[start % drive.world.places.size()];
    drive.world.map_T_start = {from.x(), from.y(), 1.0};
    drive.world.returns.clear();
  }
  SimulationOptions options{.duration_s = 150.0, .realism = drive.realism};
  options.laser.beams = 541;
  options.laser.range_max_m = kReachM;
  Mapper mapper(RobotModel{}, MapOptions{}, {2});
  simulate(drive.world, RobotModel{}, options, seed + start,
           {.message = [&](const SensorMessage& message) { mapper.add(message); },
            .truth = [&](const StampedPose2& pose) { drive.truth.append(pose.stamp, pose.pose); }});
  (void)mapper.judge_robot();
  drive.record =
      std::make_shared<const DriveRecord>(record_of(mapper.save_state().get(), MapOptions{}));
  return drive;
}

/// A point of a pane's surface.
struct PanePoint {
  Eigen::Vector2d at;
  Eigen::Vector2d normal;  ///< to the side it is seen from
  int steep = 0;           ///< poses, 20 cm apart, from where it returns a beam
  int flat = 0;            ///< and from where something behind it does, at 35 degrees and more

  [[nodiscard]] bool is_shown() const { return steep >= 2 && flat >= 3; }
};

/// The truth about the panes of a building, and what a laser could know of them.
class Panes {
 public:
  explicit Panes(const GlassDrive& drive)
      : surfaces_(drive.world.plan), path_(drive.world.plan, drive.realism, drive.world.seed) {
    for (const Box& box : drive.world.plan.boxes) {
      if (!box.is_wall) continue;
      for (const Segment& side : outline(box)) add(side);
    }
  }
  void show(const Trajectory& truth) {
    Eigen::Vector2d last = Eigen::Vector2d::Constant(1e9);
    for (const StampedPose2& pose : truth.poses()) {
      if ((pose.pose.translation() - last).norm() < 0.2) continue;
      last = pose.pose.translation();
      for (PanePoint& point : points_) look(last, point);
    }
  }
  [[nodiscard]] const std::vector<PanePoint>& points() const { return points_; }

 private:
  [[nodiscard]] double met_m(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const {
    return path_.follow(surfaces_, from, direction, kReachM, {}).range_m;
  }
  void add(const Segment& side) {
    const Eigen::Vector2d along = (side.to - side.from).normalized();
    const Eigen::Vector2d normal(along.y(), -along.x());  // sides run counter-clockwise
    for (double at = 0.025; at < (side.to - side.from).norm(); at += 0.05) {
      const Eigen::Vector2d point = side.from + at * along;
      const Eigen::Vector2d from = point + 0.2 * (normal + along);
      const Eigen::Vector2d way = point - from;
      // Else it lies inside another wall.
      if (std::abs(surfaces_.cast(from, way.normalized(), 1.0) - way.norm()) > 1e-6) continue;
      if (met_m(from, way.normalized()) > way.norm() + 0.01) points_.push_back({point, normal});
    }
  }
  void look(const Eigen::Vector2d& from, PanePoint& point) const {
    const Eigen::Vector2d way = point.at - from;
    const double range_m = way.norm();
    if (range_m > 12.0 || range_m < 0.1) return;
    const Eigen::Vector2d direction = way / range_m;
    const double incidence = std::acos(std::clamp(-direction.dot(point.normal), -1.0, 1.0));
    if (std::abs(surfaces_.cast(from, direction, kReachM) - range_m) > 0.01) return;
    if (incidence < 0.18) ++point.steep;
    if (incidence < 0.6 || incidence > 1.15) return;
    const double behind_m = (met_m(from, direction) - range_m) * std::cos(incidence);
    if (std::isfinite(behind_m) && behind_m > 0.4) ++point.flat;
  }

  SurfaceIndex surfaces_;
  BeamPath path_;
  std::vector<PanePoint> points_{};
};

/// Counted in points of panes and in cells of maps, of several buildings.
struct Found {
  int shown = 0;
  int shown_and_suspected = 0;
  int suspected = 0;
  int suspected_rightly = 0;

  [[nodiscard]] double recall() const { return static_cast<double>(shown_and_suspected) / shown; }
  [[nodiscard]] double precision() const {
    return static_cast<double>(suspected_rightly) / suspected;
  }
};

/// Calls visit(cell) for the cells whose centre lies within a reach.
template <typename Visit>
void for_each_near(const GridFrame& frame, const Eigen::Vector2d& at, double reach_m,
                   Visit&& visit) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m);
  const Cell low = frame.cell_of(at - reach);
  const Cell high = frame.cell_of(at + reach);
  for (int row = low.row; row <= high.row; ++row) {
    for (int column = low.column; column <= high.column; ++column) {
      const Cell cell{column, row};
      if (frame.contains(cell) && (frame.centre_of(cell) - at).norm() <= reach_m) visit(cell);
    }
  }
}

/// As a site draws it of sessions in one building.
void look_for_glass(const std::vector<GlassDrive>& sessions, Found& found) {
  JoinedDrives drives(MapOptions{}, {2});
  Panes panes(sessions.front());
  for (const GlassDrive& session : sessions) {
    drives.add(session.record);
    panes.show(session.truth);
  }
  GlassSurvey survey;
  VisitLedger ledger;
  const MapResult result = drives.finish(RobotModel{}, [&](const DriveVisit& visit) {
    survey.add(visit.scans, RobotModel{}.footprint_radius_m, {2});
    ledger.add(visit.map);
  });
  ASSERT_EQ(ledger.visits(), sessions.size());
  const GridFrame& frame = ledger.cells().frame();
  const AbsoluteError error =
      absolute_error(result.trajectories().front(), sessions.front().truth, Alignment::kSe2);
  ASSERT_LT(error.translation_m.rmse, 0.2);
  const Pose2 map_T_truth = error.reference_T_estimate.inverse();
  const Grid<float> glass = survey.probability(frame);
  const auto is_suspected = [&](Cell cell) {
    return static_cast<double>(glass[cell]) >= kGlassSurvey.suspected;
  };
  Grid<std::uint8_t> is_pane(frame);
  for (const PanePoint& point : panes.points()) {
    const Eigen::Vector2d at = map_T_truth * point.at;
    bool suspected = false;
    for_each_near(frame, at, 0.2, [&](Cell cell) { is_pane[cell] = 1; });
    for_each_near(frame, at, 0.1, [&](Cell cell) { suspected = suspected || is_suspected(cell); });
    if (!point.is_shown()) continue;
    ++found.shown;
    found.shown_and_suspected += suspected ? 1 : 0;
  }
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (!is_suspected({column, row})) continue;
      ++found.suspected;
      found.suspected_rightly += is_pane[{column, row}];
    }
  }
}

struct GlassBuilding {
  std::string_view world;
  std::uint64_t seed;
};

Found found_in(std::vector<GlassBuilding> buildings, const std::string& effects) {
  if (test::small_scale()) buildings.resize(1);
  Found found;
  for (const auto& [world, seed] : buildings) look_for_glass({driven(world, seed, effects)}, found);
  return found;
}

TEST(GlassInBuildings, HalfOfThePanesThatWereShownAreFoundAndNothingElse) {
  const Found found = found_in({{"rooms", 1}, {"office", 3}, {"office", 4}}, "glass");
  ASSERT_GT(found.shown, 100);
  EXPECT_TRUE(test::as_usual(1.0 - found.recall(), 0.4)) << found.recall();
  EXPECT_GT(found.precision(), 0.98);
}

TEST(GlassInBuildings, SoAreTheyByUnkindSensorsAmongPeopleAndThingsThatMove) {
  const Found found = found_in({{"rooms", 1}, {"office", 1}, {"rooms", 3}}, "usual,glass");
  ASSERT_GT(found.shown, 50);
  EXPECT_TRUE(test::as_usual(1.0 - found.recall(), 0.4)) << found.recall();
  EXPECT_GT(found.precision(), 0.97);
}

TEST(GlassInBuildings, SeveralSessionsFindMoreOfThem) {
  std::vector<GlassDrive> sessions;
  for (const std::size_t start : {0U, 4U, 8U})
    sessions.push_back(driven("office", 1, "usual,glass", start));
  Found one;
  look_for_glass({sessions.front()}, one);
  Found all;
  look_for_glass(sessions, all);
  EXPECT_GT(all.suspected_rightly, 1.5 * one.suspected_rightly);
  EXPECT_GT(all.precision(), 0.9);
}

TEST(GlassInBuildings, NoneIsSuspectedWhereThereIsNone) {
  EXPECT_EQ(found_in({{"office", 2}, {"rooms", 1}}, "none").suspected, 0);
  EXPECT_EQ(found_in({{"office", 2}, {"rooms", 3}, {"warehouse", 1}}, "usual").suspected, 0);
  EXPECT_EQ(found_in({{"office", 3}}, "usual,standers,follower").suspected, 0);
}

}  // namespace
}  // namespace loopstone
