#include "simulation/route_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace loopstone {
namespace {

constexpr double kCell = 0.1;
constexpr double kClearanceCap = 1.0;  ///< more room than this makes a way no better [m]
constexpr double kNarrowPenalty =
    2.0;                              ///< how many times dearer a way is where the robot just fits
constexpr double kUsedPenalty = 2.0;  ///< and where it has been before
constexpr double kUsedReach = 0.7;    ///< [m]
constexpr int kSmoothingRounds = 80;

struct Step {
  int columns;
  int rows;
  double length;
};
constexpr double kDiagonal = 1.4142135623730951;
constexpr std::array kSteps{Step{1, 0, 1.0},         Step{0, 1, 1.0},       Step{-1, 0, 1.0},
                            Step{0, -1, 1.0},        Step{1, 1, kDiagonal}, Step{-1, 1, kDiagonal},
                            Step{-1, -1, kDiagonal}, Step{1, -1, kDiagonal}};

}  // namespace

std::vector<double> distances_along(std::span<const Eigen::Vector2d> path) {
  std::vector<double> at_m{0.0};
  for (std::size_t i = 1; i < path.size(); ++i)
    at_m.push_back(at_m.back() + (path[i] - path[i - 1]).norm());
  return at_m;
}

Eigen::Vector2d point_along(std::span<const Eigen::Vector2d> path, std::span<const double> at_m,
                            double distance_m) {
  const auto after = std::ranges::upper_bound(at_m, distance_m);
  if (after == at_m.end()) return path.back();
  if (after == at_m.begin()) return path.front();
  const auto i = static_cast<std::size_t>(after - at_m.begin());
  const double span = at_m[i] - at_m[i - 1];
  const double ratio = span > 0.0 ? (distance_m - at_m[i - 1]) / span : 0.0;
  return path[i - 1] + ratio * (path[i] - path[i - 1]);
}

FloorPlan obstacles_of(const World& world) {
  FloorPlan plan = world.plan;
  plan.boxes.insert(plan.boxes.end(), world.keep_out.begin(), world.keep_out.end());
  return plan;
}

RoutePlanner::RoutePlanner(const SurfaceIndex& obstacles, const Extent& extent, double clearance_m)
    : obstacles_(obstacles), need_m_(clearance_m) {
  const GridFrame frame = frame_covering(extent.low, extent.high, kCell);
  clearance_ = Grid<float>(frame, 0.0f);
  free_ = Grid<std::uint8_t>(frame, 0);
  used_ = Grid<std::uint8_t>(frame, 0);
  cost_.resize(frame.cell_count());
  parent_.resize(frame.cell_count());
  round_.assign(frame.cell_count(), 0);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      const double clearance = obstacles.distance(frame.centre_of(cell), kClearanceCap);
      clearance_[cell] = static_cast<float>(clearance);
      if (clearance >= need_m_) {
        free_[cell] = 1;
        free_cells_.push_back(static_cast<std::uint32_t>(frame.index_of(cell)));
      }
    }
  }
}

Cell RoutePlanner::cell_at(std::uint32_t index) const {
  const auto columns = static_cast<std::uint32_t>(frame().columns);
  return {static_cast<int>(index % columns), static_cast<int>(index / columns)};
}

std::vector<std::uint32_t> RoutePlanner::flood(Cell start, std::uint8_t mark) {
  std::vector<std::uint32_t> cells;
  std::vector<Cell> open{start};
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    if (free_.value_or(cell, 0) != 1) continue;
    free_[cell] = mark;
    cells.push_back(static_cast<std::uint32_t>(frame().index_of(cell)));
    for (std::size_t i = 0; i < 4; ++i) {
      open.push_back({cell.column + kSteps[i].columns, cell.row + kSteps[i].rows});
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

void RoutePlanner::keep_only(std::uint8_t mark) {
  free_cells_.clear();
  for (std::size_t i = 0; i < free_.cells().size(); ++i) {
    std::uint8_t& cell = free_.cells()[i];
    cell = cell == mark ? 1 : 0;
    if (cell != 0) free_cells_.push_back(static_cast<std::uint32_t>(i));
  }
}

bool RoutePlanner::reach_from(const Eigen::Vector2d& start) {
  const std::optional<Cell> cell = nearest_free(start, 0.3);
  if (!cell) return false;
  flood(*cell, 2);
  keep_only(2);
  return true;
}

std::optional<Eigen::Vector2d> RoutePlanner::reach_largest_region(
    const std::function<bool(const Eigen::Vector2d&)>& is_inside) {
  std::vector<std::uint32_t> largest;
  for (const std::uint32_t index : free_cells_) {
    const Cell cell = cell_at(index);
    if (free_[cell] != 1 || !is_inside(frame().centre_of(cell))) continue;
    std::vector<std::uint32_t> region = flood(cell, 2);
    if (region.size() > largest.size()) largest = std::move(region);
  }
  if (largest.empty()) return std::nullopt;
  for (const std::uint32_t index : largest) free_.cells()[index] = 3;
  keep_only(3);

  Eigen::Vector2d middle(0.0, 0.0);
  for (const std::uint32_t index : largest) middle += frame().centre_of(cell_at(index));
  middle /= static_cast<double>(largest.size());
  Cell best = cell_at(largest.front());
  double best_score = std::numeric_limits<double>::infinity();
  for (const std::uint32_t index : largest) {
    const Cell cell = cell_at(index);
    const double score =
        (frame().centre_of(cell) - middle).norm() - 10.0 * static_cast<double>(clearance_[cell]);
    if (score < best_score) {
      best_score = score;
      best = cell;
    }
  }
  return frame().centre_of(best);
}

std::optional<Cell> RoutePlanner::nearest_free(const Eigen::Vector2d& point, double limit_m) const {
  const Cell middle = frame().cell_of(point);
  const int reach = static_cast<int>(std::ceil(limit_m / kCell));
  std::optional<Cell> best;
  double best_distance = limit_m;
  for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
    for (int column = middle.column - reach; column <= middle.column + reach; ++column) {
      const Cell cell{column, row};
      if (!is_free(cell)) continue;
      const double distance = (frame().centre_of(cell) - point).norm();
      if (distance < best_distance) {
        best_distance = distance;
        best = cell;
      }
    }
  }
  return best;
}

std::vector<Eigen::Vector2d> RoutePlanner::spread_points(double spacing_m) const {
  std::vector<std::uint32_t> order = free_cells_;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return clearance_.cells()[a] > clearance_.cells()[b];
  });
  std::vector<Eigen::Vector2d> points;
  for (const std::uint32_t index : order) {
    const Eigen::Vector2d point = frame().centre_of(cell_at(index));
    const bool is_apart = std::all_of(
        points.begin(), points.end(),
        [&](const Eigen::Vector2d& other) { return (other - point).norm() >= spacing_m; });
    if (is_apart) points.push_back(point);
  }
  return points;
}

std::optional<RoutePlanner::Way> RoutePlanner::find_way(Cell from, const std::vector<Cell>& goals) {
  using Entry =
      std::pair<double,
                std::uint32_t>;  // cost, cell: equal costs go by cell, so the order is fixed
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  ++current_round_;
  const auto reach = [&](Cell cell, double cost, std::uint32_t parent) {
    const std::size_t index = frame().index_of(cell);
    if (round_[index] == current_round_ && cost_[index] <= cost) return;
    round_[index] = current_round_;
    cost_[index] = cost;
    parent_[index] = parent;
    open.emplace(cost, static_cast<std::uint32_t>(index));
  };
  const auto start = static_cast<std::uint32_t>(frame().index_of(from));
  reach(from, 0.0, start);
  while (!open.empty()) {
    const auto [cost, index] = open.top();
    open.pop();
    if (cost > cost_[index]) continue;
    const Cell cell = cell_at(index);
    const auto goal = std::find(goals.begin(), goals.end(), cell);
    if (goal != goals.end()) {
      Way way{static_cast<std::size_t>(goal - goals.begin()), {}};
      for (std::uint32_t at = index; at != start; at = parent_[at])
        way.cells.push_back(cell_at(at));
      way.cells.push_back(from);
      std::reverse(way.cells.begin(), way.cells.end());
      return way;
    }
    for (const Step& step : kSteps) {
      const Cell next{cell.column + step.columns, cell.row + step.rows};
      if (!is_free(next)) continue;
      const double room =
          (static_cast<double>(clearance_[next]) - need_m_) / (kClearanceCap - need_m_);
      const double price = 1.0 + kNarrowPenalty * (1.0 - room) + kUsedPenalty * used_[next];
      reach(next, cost + step.length * kCell * price, index);
    }
  }
  return std::nullopt;
}

void RoutePlanner::mark_used(const std::vector<Cell>& cells) {
  const int reach = static_cast<int>(kUsedReach / kCell);
  for (const Cell& middle : cells) {
    for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
      for (int column = middle.column - reach; column <= middle.column + reach; ++column) {
        if (frame().contains({column, row})) used_[{column, row}] = 1;
      }
    }
  }
}

Path RoutePlanner::path_of(const std::vector<Cell>& cells) const {
  Path path;
  path.reserve(cells.size());
  for (const Cell& cell : cells) path.push_back(frame().centre_of(cell));
  return path;
}

Path RoutePlanner::smoothed(Path path) const {
  const double enough = need_m_ + 0.1;  // where there is more room, some of it may be given up
  std::vector<double> clearance(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) clearance[i] = obstacles_.distance(path[i], enough);
  for (int round = 0; round < kSmoothingRounds; ++round) {
    for (std::size_t i = 1; i + 1 < path.size(); ++i) {
      const Eigen::Vector2d candidate = 0.5 * path[i] + 0.25 * (path[i - 1] + path[i + 1]);
      const double room = obstacles_.distance(candidate, enough);
      if (room >= clearance[i]) {
        path[i] = candidate;
        clearance[i] = room;
      }
    }
  }
  return path;
}

}  // namespace loopstone
