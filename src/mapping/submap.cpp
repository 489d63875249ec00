#include "loopstone/mapping/submap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/registration/correlative_search.hpp"

namespace loopstone {

namespace {

/// The coarse level's cell is three times the fine one: the nine cells that a point enters cover
/// one cell above.
constexpr double kLevelRatio = 3.0;
/// Thinned surfaces: one piece a cell of this size and side.
constexpr double kThinCellM = 0.1;
/// A piece of surface that many scans saw counts no more than this.
constexpr float kMaxWeight = 8.0F;
/// In the search grid a surface fades out over about this distance.
constexpr double kBlurM = 0.1;
/// Rays are walked for at most this many beams of a scan: enough to know the free space.
constexpr std::size_t kMaxRays = 180;

std::array<double, 2> level_resolutions(double finest_m) {
  return {finest_m, finest_m * kLevelRatio};
}

/// How near to a surface a cell counts as, by the squared distance of its centre in hundredths of
/// the blur squared.
class Nearness {
 public:
  Nearness() {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double near = std::exp(-0.5 * (static_cast<double>(i) + 0.5) / 100.0);
      values_[i] = static_cast<std::uint8_t>(std::lround(kUnknown + near * (kSurface - kUnknown)));
    }
  }
  /// The cell's value, kContradiction (no claim) when it is too far to be touched.
  [[nodiscard]] std::uint8_t operator()(double distance2_m2) const {
    const auto index = static_cast<std::size_t>(distance2_m2 * (100.0 / (kBlurM * kBlurM)));
    return index < values_.size() ? values_[index] : kContradiction;
  }

 private:
  std::array<std::uint8_t, 625> values_{};  // out to 2.5 blurs
};

/// The bounding box of cells, growing.
struct CellBox {
  int low_column = std::numeric_limits<int>::max();
  int low_row = std::numeric_limits<int>::max();
  int high_column = std::numeric_limits<int>::min();
  int high_row = std::numeric_limits<int>::min();

  void add(Cell cell) {
    low_column = std::min(low_column, cell.column);
    low_row = std::min(low_row, cell.row);
    high_column = std::max(high_column, cell.column);
    high_row = std::max(high_row, cell.row);
  }
  [[nodiscard]] bool empty() const { return high_column < low_column; }
};

}  // namespace

Submap::Submap(const SubmapOptions& options)
    : options_(options),
      state_{SurfaceGrid(level_resolutions(options.cell_m)), BlockGrid<SurfaceCell>(kThinCellM),
             BlockGrid<std::uint8_t>(options.free_cell_m)} {}

void Submap::restore(State state) {
  bool same = state.surfaces.level_count() == state_.surfaces.level_count() &&
              state.thin_surfaces.resolution_m() == state_.thin_surfaces.resolution_m() &&
              state.free.resolution_m() == state_.free.resolution_m();
  for (std::size_t level = 0; same && level < state.surfaces.level_count(); ++level)
    same = state.surfaces.resolution_m(level) == state_.surfaces.resolution_m(level);
  require_sound(same, "a submap of other grids than the options ask for");
  state_ = std::move(state);
}

void Submap::insert(std::span<const SurfacePoint> surfaces, const LaserScan& scan,
                    const Pose2& robot_T_lidar, const Pose2& submap_T_robot, BeamTable& beams) {
  state_.surfaces.insert(surfaces, submap_T_robot);
  const Eigen::Matrix2d rotation = submap_T_robot.rotation();
  for (const SurfacePoint& surface : surfaces) {
    const Eigen::Vector2d point =
        submap_T_robot.translation() + rotation * surface.position.cast<double>();
    const Eigen::Vector2f normal = (rotation * surface.normal.cast<double>()).cast<float>();
    const Cell cell = state_.thin_surfaces.cell_of(point.x(), point.y());
    add_to(state_.thin_surfaces.at(cell), point - state_.thin_surfaces.centre_of(cell), normal,
           surface.weight);
  }

  const Pose2 submap_T_lidar = submap_T_robot * robot_T_lidar;
  const Eigen::Vector2d from = submap_T_lidar.translation();
  const Eigen::Matrix2d lidar_rotation = submap_T_lidar.rotation();
  const auto& directions = beams.directions(scan);
  const std::size_t stride =
      std::max<std::size_t>(1, (directions.size() + kMaxRays - 1) / kMaxRays);
  for (std::size_t i = 0; i < directions.size(); i += stride) {
    const double range = scan.ranges_m[i];
    double length = 0.0;
    if (std::isinf(range) && range > 0.0) length = options_.no_return_carve_m;
    if (std::isfinite(range) && range > 0.0) length = range - options_.free_cell_m;
    const Eigen::Vector2d step = lidar_rotation * directions[i] * options_.free_cell_m;
    Eigen::Vector2d point = from;
    const int steps = static_cast<int>(length / options_.free_cell_m);
    for (int k = 0; k <= steps && length > 0.0; ++k, point += step) {
      state_.free.at(state_.free.cell_of(point.x(), point.y())) = 1;
    }
  }
}

FrozenSubmap Submap::freeze() const {
  FrozenSubmap frozen;
  state_.thin_surfaces.for_each([&](Cell cell, const SurfaceCell& sums) {
    for (const SurfaceSum& sum : sums.sums) {
      // Something seen once, without a normal, is as likely a passer-by as a wall.
      if (sum.weight < 0.6F) continue;
      const float length = std::sqrt(sum.normal_x * sum.normal_x + sum.normal_y * sum.normal_y);
      if (!(length > 0.0F)) continue;
      const Eigen::Vector2d centre = state_.thin_surfaces.centre_of(cell);
      frozen.surfaces.push_back(
          {Eigen::Vector2f(static_cast<float>(centre.x()) + sum.x / sum.weight,
                           static_cast<float>(centre.y()) + sum.y / sum.weight),
           Eigen::Vector2f(sum.normal_x / length, sum.normal_y / length),
           std::min(sum.weight, kMaxWeight)});
    }
  });

  CellBox box;
  state_.free.for_each([&](Cell cell, std::uint8_t free) {
    if (free != 0) box.add(cell);
  });
  if (!box.empty()) {
    frozen.free = Grid<std::uint8_t>(GridFrame{
        .origin = {box.low_column * options_.free_cell_m, box.low_row * options_.free_cell_m},
        .resolution = options_.free_cell_m,
        .columns = box.high_column - box.low_column + 1,
        .rows = box.high_row - box.low_row + 1});
    state_.free.for_each([&](Cell cell, std::uint8_t free) {
      if (free != 0) frozen.free[{cell.column - box.low_column, cell.row - box.low_row}] = 1;
    });
    // Beams that graze a wall pass through its cells.
    for (const SurfacePoint& surface : frozen.surfaces) {
      const Cell cell = frozen.free.frame().cell_of(surface.position.cast<double>());
      if (frozen.free.frame().contains(cell)) frozen.free[cell] = 0;
    }
  }
  return frozen;
}

SurfaceGrid FrozenSubmap::surface_grid(const SubmapOptions& options) const {
  SurfaceGrid grid(std::array{options.cell_m});
  grid.insert(surfaces, Pose2{});
  return grid;
}

bool FrozenSubmap::lies_within(double reach_m) const {
  // Written so that NaN does not.
  const auto near = [&](const Eigen::Vector2d& point) {
    return (point.array().abs() <= reach_m).all();
  };
  const GridFrame& frame = free.frame();
  return std::ranges::all_of(
             surfaces,
             [&](const SurfacePoint& surface) { return near(surface.position.cast<double>()); }) &&
         (free.empty() ||
          (near(frame.origin) &&
           near(frame.origin + frame.resolution * Eigen::Vector2d(frame.columns, frame.rows))));
}

MaxPyramid FrozenSubmap::search_pyramid(const SubmapOptions& options, double half_window_m) const {
  int levels = 1;
  while (levels < 8 && (1 << levels) * options.search_cell_m <= half_window_m) ++levels;
  Eigen::Vector2d low = free.empty() ? Eigen::Vector2d(0.0, 0.0) : free.frame().origin;
  Eigen::Vector2d high = low;
  if (!free.empty())
    high += free.frame().resolution * Eigen::Vector2d(free.frame().columns, free.frame().rows);
  for (const SurfacePoint& surface : surfaces) {
    low = low.cwiseMin(surface.position.cast<double>());
    high = high.cwiseMax(surface.position.cast<double>());
  }
  Grid<std::uint8_t> cells(frame_covering(low, high, options.search_cell_m, 3.0 * kBlurM),
                           kUnknown);
  const GridFrame& frame = cells.frame();
  if (!free.empty()) {
    std::vector<int> free_columns(static_cast<std::size_t>(frame.columns));
    for (int column = 0; column < frame.columns; ++column) {
      free_columns[static_cast<std::size_t>(column)] =
          free.frame().cell_of(frame.centre_of({column, 0})).column;
    }
    for (int row = 0; row < frame.rows; ++row) {
      const int free_row = free.frame().cell_of(frame.centre_of({0, row})).row;
      if (free_row < 0 || free_row >= free.frame().rows) continue;
      for (int column = 0; column < frame.columns; ++column) {
        const int free_column = free_columns[static_cast<std::size_t>(column)];
        if (free_column < 0 || free_column >= free.frame().columns) continue;
        if (free[{free_column, free_row}] != 0) cells[{column, row}] = kContradiction;
      }
    }
  }
  // Surfaces last: near one, the record of free space is too coarse to contradict anything.
  const Nearness nearness;
  const int reach = static_cast<int>(std::ceil(2.5 * kBlurM / frame.resolution));
  std::vector<double> across2(
      static_cast<std::size_t>(2 * reach + 1));  // squared, column by column
  for (const SurfacePoint& surface : surfaces) {
    const Eigen::Vector2d point = surface.position.cast<double>();
    const Cell middle = frame.cell_of(point);
    const int first = std::max(middle.column - reach, 0);
    const int last = std::min(middle.column + reach, frame.columns - 1);
    for (int column = first; column <= last; ++column) {
      const double across = frame.centre_of({column, 0}).x() - point.x();
      across2[static_cast<std::size_t>(column - first)] = across * across;
    }
    for (int row = std::max(middle.row - reach, 0);
         row <= std::min(middle.row + reach, frame.rows - 1); ++row) {
      const double along = frame.centre_of({0, row}).y() - point.y();
      for (int column = first; column <= last; ++column) {
        auto& cell = cells[{column, row}];
        cell = std::max(
            cell, nearness(across2[static_cast<std::size_t>(column - first)] + along * along));
      }
    }
  }
  return MaxPyramid(cells, levels, kUnknown);
}

std::vector<Eigen::Vector2d> FrozenSubmap::probe(std::size_t count) const {
  std::vector<Eigen::Vector2d> points;
  if (surfaces.empty()) return points;
  const double stride =
      std::max(1.0, static_cast<double>(surfaces.size()) / static_cast<double>(count));
  for (double at = 0.0; at < static_cast<double>(surfaces.size()); at += stride) {
    points.emplace_back(surfaces[static_cast<std::size_t>(at)].position.cast<double>());
  }
  return points;
}

}  // namespace loopstone
