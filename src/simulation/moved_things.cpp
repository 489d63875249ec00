#include "simulation/moved_things.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace loopstone {
namespace {

constexpr double kLargestM = 1.3;  ///< what is longer or thicker stays where it is
constexpr double kThickestM = 0.7;
constexpr double kLegM = 0.06;   ///< thicker columns stand where they stand
constexpr double kLeafM = 0.06;  ///< a door's leaf is thinner
constexpr double kShortestLeafM = 0.7;
constexpr double kSwingRad = 1.7;  ///< a door swings by up to so much
constexpr double kClusterM = 0.9;  ///< legs in a square of this size are moved together
constexpr double kRoomM = 0.1;     ///< between a moved thing and the robot's way
constexpr std::size_t kMostStates = 64;

bool is_movable(const Box& box) {
  return !box.is_wall && box.length_m <= kLargestM && box.width_m <= kThickestM;
}
bool is_leaf(const Box& box) { return box.width_m < kLeafM && box.length_m > kShortestLeafM; }

/// The robot's way in points, to keep it clear.
class Way {
 public:
  explicit Way(const Drive& drive) {
    for (double time = 0.0; time <= drive.duration_s(); time += 0.25) {
      const Eigen::Vector2d at = drive.pose_at(time).translation();
      if (points_.empty() || (points_.back() - at).norm() > 0.1) points_.push_back(at);
    }
  }
  [[nodiscard]] bool is_clear(const Eigen::Vector2d& point, double distance_m) const {
    return std::ranges::none_of(points_, [&](const Eigen::Vector2d& at) {
      return (at - point).squaredNorm() < distance_m * distance_m;
    });
  }
  [[nodiscard]] bool is_clear(const Box& box, double distance_m) const {
    // Points along its middle line, thickness on top.
    const double reach = distance_m + 0.5 * box.width_m + 0.1;
    for (double x = -0.5 * box.length_m; x <= 0.5 * box.length_m + 0.05; x += 0.1) {
      if (!is_clear(box.map_T_box * Eigen::Vector2d(x, 0.0), reach)) return false;
    }
    return true;
  }

 private:
  std::vector<Eigen::Vector2d> points_{};
};

Eigen::Vector2d any_shift(double most_m, Rng& rng) {
  const double bearing = rng.uniform(0.0, 2.0 * kPi);
  return rng.uniform(0.2, 1.0) * most_m * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
}

Box moved_box(const Box& box, const RealismMoved& options, Rng& rng) {
  Box moved = box;
  if (is_leaf(box)) {
    const double half = rng.below(2) == 0 ? 0.5 * box.length_m : -0.5 * box.length_m;
    moved.map_T_box = box.map_T_box * Pose2{half, 0.0, rng.uniform(-kSwingRad, kSwingRad)} *
                      Pose2{-half, 0.0, 0.0};
    return moved;
  }
  const Eigen::Vector2d shift = any_shift(options.distance_m, rng);
  moved.map_T_box.x += shift.x();
  moved.map_T_box.y += shift.y();
  moved.map_T_box.yaw = wrap_angle(moved.map_T_box.yaw + rng.uniform(-0.6, 0.6));
  return moved;
}

std::uint64_t cluster_of(const Circle& leg) {
  const auto index = [](double at) {
    return static_cast<std::int64_t>(std::floor(at / kClusterM));
  };
  return static_cast<std::uint64_t>(index(leg.centre.x()) * 1'000'003 + index(leg.centre.y()));
}

}  // namespace

MovedThings::MovedThings(const World& world, const Drive& drive, double footprint_m,
                         const RealismMoved& options, Rng rng)
    : every_s_(options.every_s) {
  const Way way(drive);
  const double clear = footprint_m + kRoomM;
  FloorPlan plan = world.plan;
  states_.emplace_back(plan);
  const auto states = static_cast<std::size_t>(drive.duration_s() / options.every_s) + 1;
  std::vector<bool> box_moved(plan.boxes.size(), false);
  std::vector<bool> leg_moved(plan.circles.size(), false);
  for (std::size_t state = 1; state < std::min(states, kMostStates); ++state) {
    Rng boxes = rng.fork(2 * state);
    const Rng legs = rng.fork(2 * state + 1);
    for (std::size_t i = 0; i < plan.boxes.size(); ++i) {
      const bool is_chosen = boxes.uniform() < options.share;
      // From where it was drawn, so that nothing wanders off.
      const Box moved = moved_box(world.plan.boxes[i], options, boxes);
      if (!is_chosen || !is_movable(moved) || !way.is_clear(moved, clear)) continue;
      plan.boxes[i] = moved;
      box_moved[i] = true;
    }
    for (std::size_t i = 0; i < plan.circles.size(); ++i) {
      Circle moved = world.plan.circles[i];
      Rng cluster = legs.fork(cluster_of(moved));
      const bool is_chosen = cluster.uniform() < options.share;
      moved.centre += any_shift(options.distance_m, cluster);
      if (!is_chosen || moved.radius_m > kLegM) continue;
      if (!way.is_clear(moved.centre, clear + moved.radius_m)) continue;
      plan.circles[i] = moved;
      leg_moved[i] = true;
    }
    states_.emplace_back(plan);
  }
  moved_ = static_cast<std::size_t>(std::ranges::count(box_moved, true) +
                                    std::ranges::count(leg_moved, true));
}

const SurfaceIndex& MovedThings::surfaces_at(double time_s) const {
  const auto state = static_cast<std::size_t>(std::max(0.0, time_s / every_s_));
  return states_[std::min(state, states_.size() - 1)];
}

}  // namespace loopstone
