#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/simulation/surface_index.hpp"

// Simulated drives to measure localisation with: a map, a log of a drive in the place that it
// shows, and the truth.
namespace loopstone::bench {

/// What is asked of a drive.
struct RunRequest {
  std::string place;  ///< a built-in world's name, or a picture of a map at 5 cm, or a map's YAML
  std::uint64_t seed = 1;
  double duration_s = 60.0;
  int beams = 1081;
  int people = 0;
  int clutter =
      0;  ///< things in the map that are gone, and as many in the world that the map lacks
  int kidnaps = 0;  ///< times that the robot is carried elsewhere unseen
  std::uint64_t map_seed =
      0;               ///< not 0: the robot gets the map of another built-in place of that kind
  bool rough = false;  ///< the map is coarse and has gaps and blots, as old recorded ones do
  bool random_start = false;  ///< anywhere in the place; else where the place's drives begin
};

struct Run {
  Grid<std::int8_t> map;
  RobotModel robot{};
  std::vector<SensorMessage> messages{};
  Trajectory truth{};
  std::vector<Stamp> kidnaps{};  ///< the first scan after each
};

[[nodiscard]] inline CellStates read_any_map(const std::string& path) {
  if (path.ends_with(".yaml")) return read_ros_map(path);
  // Pictures without a YAML: Willow Garage at 10 cm, others at 5 cm.
  const bool coarse = path.find("willow") != std::string::npos;
  return interpret_map(read_image(path),
                       RosMapInfo{.image = path, .resolution_m = coarse ? 0.1 : 0.05});
}

/// A place for a robot: free on the map and farther than 0.5 m from any surface.
[[nodiscard]] inline Eigen::Vector2d random_place(const Grid<std::int8_t>& map,
                                                  const SurfaceIndex& surfaces, Rng& rng) {
  const GridFrame& frame = map.frame();
  for (;;) {
    const Cell cell{static_cast<int>(rng.below(static_cast<std::uint64_t>(frame.columns))),
                    static_cast<int>(rng.below(static_cast<std::uint64_t>(frame.rows)))};
    if (map[cell] != 0) continue;
    Eigen::Vector2d place = frame.centre_of(cell);
    if (surfaces.distance(place, 1.0) > 0.5) return place;
  }
}

/// A map as a simple recording would have it: cells twice the size, of 10 cm or more; one wall cell
/// in ten missing; one cell in seven beside a wall occupied, too.
[[nodiscard]] inline CellStates roughened(const CellStates& map, Rng& rng) {
  constexpr double kMissing = 0.1;
  constexpr double kBlots = 1.0 / 7.0;
  const auto occupied = [](std::int8_t percent) { return percent >= 65; };
  GridFrame frame = map.frame();
  frame.resolution *= 2.0;
  frame.columns = (frame.columns + 1) / 2;
  frame.rows = (frame.rows + 1) / 2;
  CellStates coarse(frame, kUnknownCell);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      for (int i = 0; i < 4; ++i) {
        const std::int8_t percent =
            map.value_or({2 * column + i % 2, 2 * row + i / 2}, kUnknownCell);
        coarse[{column, row}] = std::max(coarse[{column, row}], percent);
      }
    }
  }
  CellStates rough = coarse;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const bool wall = occupied(coarse[{column, row}]);
      bool beside = false;
      for (int i = 0; i < 9; ++i) {
        beside =
            beside || occupied(coarse.value_or({column + i % 3 - 1, row + i / 3 - 1}, kFreeCell));
      }
      if (wall && rng.uniform() < kMissing) rough[{column, row}] = kFreeCell;
      if (!wall && beside && rng.uniform() < kBlots) rough[{column, row}] = kOccupiedCell;
    }
  }
  return rough;
}

/// In a world made from a map what is unknown is solid, and so is everything beyond its edge: the
/// map that the robot gets says so.
[[nodiscard]] inline CellStates with_solid_unknown(const CellStates& map) {
  GridFrame frame = map.frame();
  frame.origin -= Eigen::Vector2d::Constant(frame.resolution);
  frame.columns += 2;
  frame.rows += 2;
  CellStates solid(frame, kOccupiedCell);
  for (int row = 0; row < map.frame().rows; ++row) {
    for (int column = 0; column < map.frame().columns; ++column) {
      const std::int8_t percent = map[{column, row}];
      if (percent >= 0) solid[{column + 1, row + 1}] = percent;
    }
  }
  return solid;
}

/// Boxes and columns where there is room for them and for a robot to pass.
inline void add_clutter(World& world, const Grid<std::int8_t>& map, int count, Rng& rng) {
  for (int i = 0; i < count; ++i) {
    const SurfaceIndex surfaces(world.plan);
    const Eigen::Vector2d place = random_place(map, surfaces, rng);
    if ((place - world.map_T_start.translation()).norm() < 1.5) continue;
    if (rng.uniform() < 0.5) {
      world.plan.circles.push_back({place, rng.uniform(0.1, 0.3)});
    } else {
      world.plan.boxes.push_back({{place.x(), place.y(), rng.uniform(-kPi, kPi)},
                                  rng.uniform(0.3, 1.0),
                                  rng.uniform(0.3, 0.6)});
    }
  }
}

/// The map of a world that was made from a map, with what was added since. true_map() would draw
/// the added things and miss the walls: they are borders between cells here, within half a cell of
/// no cell's centre.
[[nodiscard]] inline CellStates with_added(const CellStates& given, const FloorPlan& plan) {
  CellStates map = given;
  const GridFrame& frame = map.frame();
  const auto draw = [&](const auto& thing, const Eigen::Vector2d& centre, double reach) {
    const Cell low = frame.cell_of(centre.array() - reach);
    const Cell high = frame.cell_of(centre.array() + reach);
    for (int row = low.row; row <= high.row; ++row) {
      for (int column = low.column; column <= high.column; ++column) {
        const Cell cell{column, row};
        if (frame.contains(cell) && is_inside(thing, frame.centre_of(cell)))
          map[cell] = kOccupiedCell;
      }
    }
  };
  for (const Circle& circle : plan.circles) draw(circle, circle.centre, circle.radius_m);
  for (const Box& box : plan.boxes)
    draw(box, box.map_T_box.translation(), 0.5 * std::hypot(box.length_m, box.width_m));
  return map;
}

/// Carries the robot on by part of its own route, unseen: what was recorded meanwhile is left out,
/// and the clock goes on as if nothing had happened.
inline void kidnap(Run& run, double at_s, double for_s) {
  const Stamp first = stamp_of(run.messages.front());
  const Duration from{static_cast<std::int64_t>(at_s * 1e9)};
  const Duration gap{static_cast<std::int64_t>(for_s * 1e9)};
  const Duration until{static_cast<std::int64_t>((at_s + for_s) * 1e9)};
  const auto shifted = [&](Stamp stamp) { return stamp - gap; };
  std::vector<SensorMessage> kept;
  for (SensorMessage& message : run.messages) {
    const Duration time = stamp_of(message) - first;
    if (time > from && time <= until) continue;
    if (time > until) std::visit([&](auto& m) { m.stamp = shifted(m.stamp); }, message);
    kept.push_back(std::move(message));
  }
  run.messages = std::move(kept);
  std::vector<StampedPose2> truth;
  bool carried = false;
  for (const StampedPose2& pose : run.truth.poses()) {
    const Duration time = pose.stamp - first;
    if (time > from && time <= until) continue;
    const bool after = time > until;
    truth.push_back({after ? shifted(pose.stamp) : pose.stamp, pose.pose});
    if (after && !carried) run.kidnaps.push_back(truth.back().stamp);
    carried = carried || after;
  }
  run.truth = Trajectory(std::move(truth));
}

[[nodiscard]] inline Run make_run(const RunRequest& request) {
  Rng rng = Rng(request.seed).fork(77);
  const bool built_in = request.place.find('.') == std::string::npos;
  RobotModel robot;
  World world = built_in ? make_world(request.place, request.seed)
                         : make_world(with_solid_unknown(read_any_map(request.place)),
                                      request.place, robot.footprint_radius_m + 0.1);
  const Grid<std::int8_t> bare = true_map(world);
  World mapped = world;
  Run run{.map = bare, .robot = robot};
  if (request.clutter > 0) {
    add_clutter(mapped, bare, request.clutter, rng);
    add_clutter(world, bare, request.clutter, rng);
    run.map = built_in ? true_map(mapped) : with_added(bare, mapped.plan);
  }
  if (request.rough) run.map = roughened(run.map, rng);
  if (request.map_seed != 0) run.map = true_map(make_world(request.place, request.map_seed));
  if (request.random_start) {
    const Eigen::Vector2d start = world.places[rng.below(world.places.size())];
    world.map_T_start = {start.x(), start.y(), rng.uniform(-kPi, kPi)};
    const auto nearer = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return (a - start).norm() < (b - start).norm();
    };
    std::stable_sort(world.places.begin(), world.places.end(), nearer);
    if (world.places.size() > 6) world.places.resize(6);
    world.returns.clear();
  }
  SimulationOptions options;
  const double carried_s = 25.0;
  options.duration_s = request.duration_s + carried_s * request.kidnaps;
  options.people = request.people;
  options.laser.beams = request.beams;
  options.drive.standstill_s = 0.5;
  std::vector<StampedPose2> truth;
  simulate(world, robot, options, request.seed,
           {.message = [&](SensorMessage message) { run.messages.push_back(std::move(message)); },
            .truth = [&](const StampedPose2& pose) { truth.push_back(pose); }});
  run.truth = Trajectory(std::move(truth));
  for (int i = 0; i < request.kidnaps; ++i) {
    const double at_s = request.duration_s * (i + 1) / (request.kidnaps + 1);
    kidnap(run, at_s, carried_s * rng.uniform(0.5, 1.0));
  }
  return run;
}

struct PoseError {
  double metres = 0.0;
  double radians = 0.0;
  /// What the probability of an estimate is about.
  [[nodiscard]] bool right() const { return metres <= 0.2 && radians <= 5.0 * kPi / 180.0; }
};

[[nodiscard]] inline PoseError error_of(const Pose2& pose, const Pose2& truth) {
  return {std::hypot(pose.x - truth.x, pose.y - truth.y),
          std::abs(wrap_angle(pose.yaw - truth.yaw))};
}

[[nodiscard]] inline PoseError error_of(const LocalizationEstimate& estimate, const Run& run) {
  return error_of(estimate.map_T_robot, *run.truth.at_clamped(estimate.stamp));
}

/// Calls set(key, value) for each KEY=VALUE after the first argument of a program.
template <typename Set>
void for_each_setting(int argc, char** argv, Set&& set) {
  for (int i = 2; i < argc; ++i) {
    const std::string text = argv[i];
    const auto sign = text.find('=');
    set(text.substr(0, sign), sign == std::string::npos ? "" : text.substr(sign + 1));
  }
}

}  // namespace loopstone::bench
