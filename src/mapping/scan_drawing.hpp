#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "loopstone/grid/ray_walk.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "mapping/grazing_beams.hpp"
#include "mapping/grid_beam.hpp"
#include "mapping/scan_beams.hpp"
#include "mapping/scan_raster.hpp"

// How one scan changes the cells of a map, whatever the map is kept in.

namespace loopstone {

[[nodiscard]] inline float log_odds_of(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

/// How a cell changes, in log-odds.
struct CellUpdates {
  float hit;
  float miss;
  float limit;

  explicit CellUpdates(const OccupancyOptions& options)
      : hit(log_odds_of(options.hit_probability)),
        miss(log_odds_of(options.miss_probability)),
        limit(log_odds_of(options.clamp_probability)) {}

  /// \param cells  of log-odds, and whether they were observed: 64 of a row from where the bits
  ///               begin
  void apply(std::uint64_t passed_bits, std::uint64_t hit_bits, float* log_odds,
             std::uint8_t* observed) const {
    for (; passed_bits != 0; passed_bits &= passed_bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(passed_bits));
      log_odds[i] = std::max(log_odds[i] + miss, -limit);
      observed[i] = 1;
    }
    for (; hit_bits != 0; hit_bits &= hit_bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(hit_bits));
      log_odds[i] = std::min(log_odds[i] + hit, limit);
      observed[i] = 1;
    }
  }
};

/// The beams of a scan on the grid and the box of cells that they stay in.
struct ScanBeams {
  std::vector<GridBeam> beams{};
  Cell low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  Cell high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};

  void include(Cell cell) {
    low = {std::min(low.column, cell.column), std::min(low.row, cell.row)};
    high = {std::max(high.column, cell.column), std::max(high.row, cell.row)};
  }
};

/// So near to a surface that a beam grazes, it says nothing of cells being free.
inline constexpr double kNearSurfaceCells = 1.0;

[[nodiscard]] inline ScanBeams beams_on_grid(const PosedScan& posed, const GridFrame& frame,
                                             const OccupancyOptions& options, BeamTable& table) {
  ScanBeams result;
  if (!usable(posed)) return result;
  std::vector<Beam> beams;
  beams.reserve(posed.scan->ranges_m.size());
  for_each_beam(posed, options, table, [&](const Beam& beam) { beams.push_back(beam); });
  result.beams.reserve(beams.size());
  Cell before{};
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Beam& beam = beams[i];
    const Cell end = cell_of(grid_point_of(frame, beam.end));
    // Neighbours that end in one cell cross the same cells.
    if (!result.beams.empty() && result.beams.back().hit.has_value() == beam.hit && before == end)
      continue;
    before = end;
    GridBeam segment{
        grid_point_of(frame, beam.start),
        grid_point_of(frame, free_end(beams, i, kNearSurfaceCells * frame.resolution))};
    if (beam.hit) segment.hit = end;
    result.include(cell_of(segment.start));
    result.include(end);
    result.beams.push_back(segment);
  }
  skip_shared_rows(result.beams);
  return result;
}

/// Tells what lies in rows [first_row, end_row) of a scan: end points win over what other beams
/// passed.
/// \param on_word  (row, column of bit 0, passed, hit); the column is a multiple of 64
template <typename OnWord>
void raster_scan(const ScanBeams& scan, int first_row, int end_row, ScanRaster& raster,
                 OnWord&& on_word) {
  if (scan.low.row >= end_row || scan.high.row < first_row) return;
  raster.start({scan.low.column, std::max(scan.low.row, first_row)},
               {scan.high.column, std::min(scan.high.row, end_row - 1)});
  for (const GridBeam& beam : scan.beams) {
    if (beam.hit && beam.hit->row >= first_row && beam.hit->row < end_row)
      raster.mark_hit(*beam.hit);
    const bool up = beam.end.y >= beam.start.y;
    walk_ray_rows(beam.start, beam.end, up ? std::max(first_row, beam.walked_from_row) : first_row,
                  up ? end_row : std::min(end_row, beam.walked_from_row + 1),
                  [&](int row, int first_column, int last_column) {
                    raster.mark_passed(row, first_column, last_column);
                  });
  }
  raster.finish(on_word);
}

/// Consecutive poses nearer than this are joined to one swept footprint; a longer gap is a jump (an
/// interrupted log).
inline constexpr double kMostSweepM = 1.0;
/// A robot that stands still need not be drawn again; less of a cell changes nothing that matters.
inline constexpr double kLeastSweepCells = 0.05;

/// Calls visit(Cell) for every cell whose centre lies within the radius of the segment between two
/// positions of the robot.
template <typename Visit>
void for_each_swept_cell(const GridFrame& frame, const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to, double radius_m, Visit&& visit) {
  const Eigen::Vector2d radius = Eigen::Vector2d::Constant(radius_m);
  const Cell low = frame.cell_of(from.cwiseMin(to) - radius);
  const Cell high = frame.cell_of(from.cwiseMax(to) + radius);
  const Eigen::Vector2d along = to - from;
  const double length_squared = along.squaredNorm();
  for (int row = low.row; row <= high.row; ++row) {
    for (int column = low.column; column <= high.column; ++column) {
      const Cell cell{column, row};
      const Eigen::Vector2d offset = frame.centre_of(cell) - from;
      const double ratio =
          length_squared > 0.0 ? std::clamp(offset.dot(along) / length_squared, 0.0, 1.0) : 0.0;
      if ((offset - ratio * along).squaredNorm() > radius_m * radius_m) continue;
      visit(cell);
    }
  }
}

/// The cells that the robot's footprint sweeps on its way to a position.
/// \param before  where it was drawn last, if anywhere; then the position, unless it hardly moved
template <typename Visit>
void sweep_footprint(const GridFrame& frame, const Eigen::Vector2d& position, double radius_m,
                     std::optional<Eigen::Vector2d>& before, Visit&& visit) {
  const double moved_m = before ? (position - *before).norm() : 0.0;
  if (before && moved_m < kLeastSweepCells * frame.resolution) return;
  const bool sweeps = before && moved_m <= kMostSweepM;
  for_each_swept_cell(frame, sweeps ? *before : position, position, radius_m, visit);
  before = position;
}

}  // namespace loopstone
