#include <algorithm>
#include <array>
#include <cmath>

#include "loopstone/simulation/realism.hpp"

namespace loopstone {
namespace {

constexpr double kPieceM = 1.0;     ///< bent things are made of straight pieces of this length
constexpr double kOverlapM = 0.02;  ///< by which pieces reach into each other
constexpr double kRigidM = 1.5;     ///< things shorter than this are not bent

/// A smooth displacement of the plane: a few plane waves.
class Bend {
 public:
  Bend(const RealismBent& options, Rng rng) {
    for (Wave& wave : waves_) {
      const double heading = rng.uniform(0.0, 2.0 * kPi);
      const double push = rng.uniform(0.0, 2.0 * kPi);
      const double length = options.wavelength_m * rng.uniform(0.7, 1.3);
      // Their squares add up to the amplitude's.
      const double size = options.amplitude_m / std::sqrt(static_cast<double>(waves_.size()));
      wave.number = 2.0 * kPi / length * Eigen::Vector2d(std::cos(heading), std::sin(heading));
      wave.push_m = size * Eigen::Vector2d(std::cos(push), std::sin(push));
      wave.phase_rad = rng.uniform(0.0, 2.0 * kPi);
    }
  }

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& point) const {
    Eigen::Vector2d moved = point;
    for (const Wave& wave : waves_)
      moved += std::sin(wave.number.dot(point) + wave.phase_rad) * wave.push_m;
    return moved;
  }

  /// A short thing goes with its middle and turns with its x axis.
  [[nodiscard]] Pose2 operator()(const Pose2& pose) const {
    const Eigen::Vector2d at = (*this)(pose.translation());
    const Eigen::Vector2d along = (*this)(pose * Eigen::Vector2d(0.1, 0.0)) - at;
    return {at.x(), at.y(), std::atan2(along.y(), along.x())};
  }

 private:
  struct Wave {
    Eigen::Vector2d number;  ///< [rad/m]
    Eigen::Vector2d push_m;
    double phase_rad = 0.0;
  };
  std::array<Wave, 3> waves_;
};

int pieces_of(double length_m) { return static_cast<int>(std::ceil(length_m / kPieceM)); }

std::vector<Box> bent(const std::vector<Box>& boxes, const Bend& bend) {
  std::vector<Box> result;
  for (const Box& box : boxes) {
    if (box.length_m < kRigidM) {
      result.push_back({bend(box.map_T_box), box.length_m, box.width_m, box.is_wall});
      continue;
    }
    const int pieces = pieces_of(box.length_m);
    Eigen::Vector2d from = bend(box.map_T_box * Eigen::Vector2d(-0.5 * box.length_m, 0.0));
    for (int piece = 1; piece <= pieces; ++piece) {
      const double x = box.length_m * (static_cast<double>(piece) / pieces - 0.5);
      const Eigen::Vector2d to = bend(box.map_T_box * Eigen::Vector2d(x, 0.0));
      const Eigen::Vector2d middle = 0.5 * (from + to);
      const double yaw = std::atan2(to.y() - from.y(), to.x() - from.x());
      result.push_back({{middle.x(), middle.y(), yaw},
                        (to - from).norm() + kOverlapM,
                        box.width_m,
                        box.is_wall});
      from = to;
    }
  }
  return result;
}

std::vector<Segment> bent(const std::vector<Segment>& surfaces, const Bend& bend) {
  std::vector<Segment> result;
  for (const Segment& surface : surfaces) {
    const Eigen::Vector2d along = surface.to - surface.from;
    const int pieces = std::max(1, pieces_of(along.norm()));
    for (int piece = 0; piece < pieces; ++piece) {
      const double step = 1.0 / pieces;
      result.push_back({bend(Eigen::Vector2d(surface.from + piece * step * along)),
                        bend(Eigen::Vector2d(surface.from + (piece + 1) * step * along))});
    }
  }
  return result;
}

World bent(World world, const Bend& bend) {
  world.plan.boxes = bent(world.plan.boxes, bend);
  world.keep_out = bent(world.keep_out, bend);
  world.plan.surfaces = bent(world.plan.surfaces, bend);
  for (Circle& circle : world.plan.circles) circle.centre = bend(circle.centre);
  for (Eigen::Vector2d& place : world.places) place = bend(place);
  for (Eigen::Vector2d& point : world.returns) point = bend(point);
  world.map_T_start = bend(world.map_T_start);
  world.given_map.reset();
  return world;
}

World turned(World world, double yaw_rad) {
  const Pose2 turn{0.0, 0.0, yaw_rad};
  for (std::vector<Box>* boxes : {&world.plan.boxes, &world.keep_out}) {
    for (Box& box : *boxes) box.map_T_box = turn * box.map_T_box;
  }
  for (Segment& surface : world.plan.surfaces) surface = {turn * surface.from, turn * surface.to};
  for (Circle& circle : world.plan.circles) circle.centre = turn * circle.centre;
  for (Eigen::Vector2d& place : world.places) place = turn * place;
  for (Eigen::Vector2d& point : world.returns) point = turn * point;
  world.map_T_start = turn * world.map_T_start;
  world.given_map.reset();
  return world;
}

}  // namespace

World real_world(World world, const Realism& realism, std::uint64_t seed, RealismRecord& record) {
  if (realism.bent.on)
    world = bent(std::move(world), Bend(realism.bent, realism_stream(seed, "bent")));
  if (realism.turned.on) {
    const double yaw_rad = realism_stream(seed, "turned").uniform(-kPi, kPi);
    record.facts.push_back({"turned", "yaw_rad", yaw_rad});
    world = turned(std::move(world), yaw_rad);
  }
  return world;
}

}  // namespace loopstone
