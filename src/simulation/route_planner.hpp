#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

using Path = std::vector<Eigen::Vector2d>;  ///< map frame, points about 0.1 m apart

/// How far each point of a path lies along it, from 0 on [m].
[[nodiscard]] std::vector<double> distances_along(std::span<const Eigen::Vector2d> path);
/// The point that far along a path; before it and beyond it, its ends.
/// \param at_m  its distances_along
[[nodiscard]] Eigen::Vector2d point_along(std::span<const Eigen::Vector2d> path,
                                          std::span<const double> at_m, double distance_m);

/// What keeps a robot out: all that a laser sees, and the keep-out boxes.
[[nodiscard]] FloorPlan obstacles_of(const World& world);

/// Finds ways for a round robot over a grid of clearances. Cells that a way went through before may
/// be made dearer, so that the next way prefers others.
class RoutePlanner {
 public:
  /// \param clearance_m  distance that the robot's centre keeps from every obstacle
  RoutePlanner(const SurfaceIndex& obstacles, const Extent& extent, double clearance_m);

  /// Restricts the free cells to those that can be reached from here. False when here itself is
  /// blocked.
  bool reach_from(const Eigen::Vector2d& start);
  /// Restricts the free cells to the largest connected region, in which a start is then returned:
  /// the cell with the most room among those near the region's middle. Nothing when no cell is
  /// free.
  /// \param is_inside  regions that begin where this says no are left out: a solid given by its
  ///                   surfaces alone is hollow
  [[nodiscard]] std::optional<Eigen::Vector2d> reach_largest_region(
      const std::function<bool(const Eigen::Vector2d&)>& is_inside);

  /// The free cell nearest to a point, within `limit_m`.
  [[nodiscard]] std::optional<Cell> nearest_free(const Eigen::Vector2d& point,
                                                 double limit_m) const;
  /// Points spread over the free region, none nearer to another than the spacing; the roomiest
  /// first.
  [[nodiscard]] std::vector<Eigen::Vector2d> spread_points(double spacing_m) const;
  [[nodiscard]] const std::vector<std::uint32_t>& free_cells() const { return free_cells_; }
  [[nodiscard]] const GridFrame& frame() const { return clearance_.frame(); }

  struct Way {
    std::size_t goal = 0;  ///< index of the goal that was reached
    std::vector<Cell> cells;
  };
  /// The cheapest way to whichever goal is cheapest to reach (Dijkstra); nothing when none can be.
  [[nodiscard]] std::optional<Way> find_way(Cell from, const std::vector<Cell>& goals);
  /// Makes the surroundings of a way dearer from now on.
  void mark_used(const std::vector<Cell>& cells);

  [[nodiscard]] Path path_of(const std::vector<Cell>& cells) const;
  /// Rounds the corners of a path, its ends fixed, without losing clearance where there is little.
  [[nodiscard]] Path smoothed(Path path) const;

 private:
  [[nodiscard]] bool is_free(Cell cell) const { return free_.value_or(cell, 0) != 0; }
  /// The cells connected to `start` among those with mark 1 get mark `mark`; returns them.
  std::vector<std::uint32_t> flood(Cell start, std::uint8_t mark);
  void keep_only(std::uint8_t mark);
  [[nodiscard]] Cell cell_at(std::uint32_t index) const;

  const SurfaceIndex& obstacles_;
  double need_m_;
  Grid<float> clearance_{};  ///< capped
  Grid<std::uint8_t> free_{};
  Grid<std::uint8_t> used_{};
  std::vector<std::uint32_t> free_cells_{};
  // Of the search under way; entries are valid where round_ == current_round_.
  std::vector<double> cost_{};
  std::vector<std::uint32_t> parent_{};
  std::vector<std::uint32_t> round_{};
  std::uint32_t current_round_ = 0;
};

}  // namespace loopstone
