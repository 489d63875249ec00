#include "loopstone/registration/likelihood_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/distance_transform.hpp"

namespace loopstone {

namespace {

/// Cells of twice the size, with the field's value at their centres: the mean of the four cells
/// around each.
Grid<float> halved(const Grid<float>& fine) {
  GridFrame frame = fine.frame();
  frame.resolution *= 2.0;
  frame.columns = (frame.columns + 1) / 2;
  frame.rows = (frame.rows + 1) / 2;
  Grid<float> coarse(frame);
  const int last_column = fine.frame().columns - 1;
  const int last_row = fine.frame().rows - 1;
  for (int row = 0; row < frame.rows; ++row) {
    const int upper = std::min(2 * row + 1, last_row);
    for (int column = 0; column < frame.columns; ++column) {
      const int right = std::min(2 * column + 1, last_column);
      coarse[{column, row}] = 0.25F * (fine[{2 * column, 2 * row}] + fine[{right, 2 * row}] +
                                       fine[{2 * column, upper}] + fine[{right, upper}]);
    }
  }
  return coarse;
}

/// A wall's direction is told by its cells this near, and no fewer than some rows of them.
constexpr double kNormalReachM = 0.25;
constexpr int kLeastReach = 3;
/// Cells lie on a line that spread along it more than twice as far as across.
constexpr double kLongerThanWide = 4.0;

/// Cells of a window around one of them, and which of them hang together with it: the other face of
/// a wall is another one.
class Patch {
 public:
  explicit Patch(int reach) : reach_(reach), side_(2 * reach + 1) {}

  template <typename Visit>
  void visit_connected(const Grid<std::uint8_t>& walls, const Cell& middle, Visit&& visit) {
    seen_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), false);
    open_.assign(1, {0, 0});
    mark(0, 0);
    while (!open_.empty()) {
      const auto [column, row] = open_.back();
      open_.pop_back();
      visit(column, row);
      for (int r = row - 1; r <= row + 1; ++r) {
        for (int c = column - 1; c <= column + 1; ++c) {
          if (std::max(std::abs(c), std::abs(r)) > reach_ ||
              walls.value_or({middle.column + c, middle.row + r}, 0) == 0 || !mark(c, r)) {
            continue;
          }
          open_.emplace_back(c, r);
        }
      }
    }
  }

 private:
  /// Whether it was not marked before.
  bool mark(int column, int row) {
    const auto index = static_cast<std::size_t>((row + reach_) * side_ + column + reach_);
    if (seen_[index]) return false;
    return seen_[index] = true;
  }

  int reach_;
  int side_;
  std::vector<bool> seen_{};
  std::vector<std::pair<int, int>> open_{};
};

/// The normal of a wall at one of its cells in whole degrees and one; 0 where the cells around lie
/// on no line.
std::uint8_t normal_at(const Grid<std::uint8_t>& walls, const Cell& cell, Patch& patch) {
  double count = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  patch.visit_connected(walls, cell, [&](int column, int row) {
    const Eigen::Vector2d at(column, row);
    count += 1.0;
    sum += at;
    squares += at * at.transpose();
  });
  const Eigen::Matrix2d spread = squares / count - sum * sum.transpose() / (count * count);
  const double half_trace = 0.5 * spread.trace();
  const double half_gap = 0.5 * (spread(0, 0) - spread(1, 1));
  const double off = hypotenuse(half_gap, spread(0, 1));
  if (!(half_trace + off > kLongerThanWide * (half_trace - off)) || count < 3.0) return 0;
  const double along = 0.5 * std::atan2(spread(0, 1), half_gap);
  const int degrees = static_cast<int>(std::lround(along * 180.0 / kPi)) + 90;
  return static_cast<std::uint8_t>(1 + ((degrees % 180) + 180) % 180);
}

Grid<std::uint8_t> normals_of(const Grid<std::uint8_t>& walls) {
  const GridFrame& frame = walls.frame();
  const int reach =
      std::max(kLeastReach, static_cast<int>(std::lround(kNormalReachM / frame.resolution)));
  Patch patch(reach);
  Grid<std::uint8_t> normals(frame, 0);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (walls[{column, row}] != 0)
        normals[{column, row}] = normal_at(walls, {column, row}, patch);
    }
  }
  return normals;
}

}  // namespace

Grid<std::uint8_t> visible_walls(const Grid<std::int8_t>& occupancy, int occupied_percent) {
  const GridFrame& frame = occupancy.frame();
  const auto is_free = [&](std::int8_t percent) {
    return percent >= 0 && percent < occupied_percent;
  };
  const bool any_free = std::any_of(occupancy.cells().begin(), occupancy.cells().end(), is_free);
  Grid<std::uint8_t> walls(frame, 0);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (occupancy[{column, row}] < occupied_percent) continue;
      bool seen = !any_free;
      for (int r = row - 1; r <= row + 1 && !seen; ++r) {
        for (int c = column - 1; c <= column + 1 && !seen; ++c)
          seen = is_free(occupancy.value_or({c, r}, -1));
      }
      walls[{column, row}] = seen ? 1 : 0;
    }
  }
  return walls;
}

std::vector<Eigen::Vector2d> wall_points(const Grid<std::int8_t>& occupancy, int occupied_percent) {
  const Grid<std::uint8_t> walls = visible_walls(occupancy, occupied_percent);
  std::vector<Eigen::Vector2d> points;
  for (int row = 0; row < walls.frame().rows; ++row) {
    for (int column = 0; column < walls.frame().columns; ++column) {
      if (walls[{column, row}] != 0) points.push_back(walls.frame().centre_of({column, row}));
    }
  }
  return points;
}

MapField::MapField(const Grid<std::int8_t>& occupancy, const MapFieldOptions& options)
    : reach_m_(options.reach_m) {
  const Grid<std::uint8_t> walls = visible_walls(occupancy, options.occupied_percent);
  normals_ = normals_of(walls);
  levels_.push_back(distance_transform(walls));
  const auto farthest =
      static_cast<float>(options.reach_m * static_cast<double>(1U << (options.levels - 1)));
  for (float& distance : levels_.front().cells()) distance = std::min(distance, farthest);
  for (int level = 1; level < options.levels; ++level) levels_.push_back(halved(levels_.back()));
}

std::size_t MapField::memory_bytes() const {
  std::size_t bytes = normals_.cells().size();
  for (const auto& level : levels_) bytes += level.cells().size() * sizeof(float);
  return bytes;
}

FieldSample MapField::sample(std::size_t level, const Eigen::Vector2d& point) const {
  const Grid<float>& grid = levels_[level];
  const GridFrame& frame = grid.frame();
  const double reach = reach_m(level);
  FieldSample sample{.distance_m = reach};
  // In cells from the centre of cell (0, 0).
  const double x = (point.x() - frame.origin.x()) / frame.resolution - 0.5;
  const double y = (point.y() - frame.origin.y()) / frame.resolution - 0.5;
  if (!(x >= 0.0 && y >= 0.0 && x < frame.columns - 1 && y < frame.rows - 1)) return sample;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double right = x - column;
  const double up = y - row;
  const float* const corner = &grid.cells()[frame.index_of({column, row})];
  const double low_left = static_cast<double>(corner[0]);
  const double low_right = static_cast<double>(corner[1]);
  const double high_left = static_cast<double>(corner[frame.columns]);
  const double high_right = static_cast<double>(corner[frame.columns + 1]);
  const double low = low_left + right * (low_right - low_left);
  const double high = high_left + right * (high_right - high_left);
  const double distance = low + up * (high - low);
  if (!(distance < reach)) return sample;
  sample.distance_m = distance;
  const double along_x =
      (low_right - low_left) + up * ((high_right - high_left) - (low_right - low_left));
  sample.gradient = Eigen::Vector2d(along_x, high - low) / frame.resolution;
  return sample;
}

Eigen::Vector2d MapField::wall_normal(const Eigen::Vector2d& point,
                                      const FieldSample& sample) const {
  const double steepness = sample.gradient.norm();
  if (!(steepness > 0.0)) return sample.gradient;
  const Eigen::Vector2d foot = point - (sample.distance_m / steepness) * sample.gradient;
  const Cell at = normals_.frame().cell_of(foot);
  double nearest2 = std::numeric_limits<double>::infinity();
  int degrees = 0;
  for (int row = at.row - 1; row <= at.row + 1; ++row) {
    for (int column = at.column - 1; column <= at.column + 1; ++column) {
      const int found = normals_.value_or({column, row}, 0);
      if (found == 0) continue;
      const double distance2 = (normals_.frame().centre_of({column, row}) - foot).squaredNorm();
      if (distance2 >= nearest2) continue;
      nearest2 = distance2;
      degrees = found;
    }
  }
  if (degrees == 0) return sample.gradient;
  const double angle = (degrees - 1) * kPi / 180.0;
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  return normal.dot(sample.gradient) < 0.0 ? Eigen::Vector2d(-normal) : normal;
}

}  // namespace loopstone
