#include "loopstone/mapping/occupancy.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"
#include "loopstone/grid/ray_walk.hpp"
#include "mapping/grid_beam.hpp"
#include "mapping/scan_beams.hpp"
#include "mapping/scan_raster.hpp"

namespace loopstone {
namespace {

/// Consecutive poses nearer than this are joined to one swept footprint; a longer gap is a jump (an interrupted log).
constexpr double kMostSweepM = 1.0;
/// Beams are kept for so many at a time, which bounds the memory for any length of log.
constexpr std::size_t kBeamsPerBatch = std::size_t{1} << 18;
/// Scans that one task of the preparation handles.
constexpr std::size_t kScansPerTask = 64;
/// A map that is too large is drawn with cells up to so wide.
constexpr double kWidestCellM = 1.0;
/// Along one side.
constexpr double kMostColumns = 1e6;

float log_odds_of(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  void include(const Eigen::Vector2d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

Bounds bounds_of(std::span<const PosedScan> scans, double footprint_radius_m,
                 const OccupancyOptions& options, Threads threads) {
  const std::size_t tasks = (scans.size() + kScansPerTask - 1) / kScansPerTask;
  std::vector<Bounds> parts(tasks);
  parallel_for(tasks, threads, [&](std::size_t task) {
    BeamTable table;
    Bounds bounds;
    const std::size_t first = task * kScansPerTask;
    for (const PosedScan& posed :
         scans.subspan(first, std::min(kScansPerTask, scans.size() - first))) {
      if (!usable(posed)) continue;
      const Eigen::Vector2d radius = Eigen::Vector2d::Constant(footprint_radius_m);
      bounds.include(posed.map_T_robot.translation() - radius);
      bounds.include(posed.map_T_robot.translation() + radius);
      for_each_beam(posed, options, table, [&](const Beam& beam) {
        bounds.include(beam.start);
        bounds.include(beam.end);
      });
    }
    parts[task] = bounds;
  });
  Bounds all;
  for (const Bounds& part : parts) {
    all.low = all.low.cwiseMin(part.low);
    all.high = all.high.cwiseMax(part.high);
  }
  return all;
}

std::string extent_text(double width_m, double height_m) {
  return number_text(width_m, 4) + " m x " + number_text(height_m, 4) + " m";
}

GridFrame frame_of(const Bounds& bounds, const OccupancyOptions& options) {
  double resolution_m = options.resolution_m;
  if (!(bounds.low.array() <= bounds.high.array()).all()) {  // nothing was seen: one unknown cell
    return {.origin = {0.0, 0.0}, .resolution = resolution_m, .columns = 1, .rows = 1};
  }
  const Eigen::Vector2d size = bounds.high - bounds.low;
  const auto fits = [&] {
    const double cells = (size.x() / resolution_m + 3.0) * (size.y() / resolution_m + 3.0);
    return cells < static_cast<double>(options.most_cells) &&
           size.maxCoeff() / resolution_m < kMostColumns;
  };
  while (!fits() && 2.0 * resolution_m <= kWidestCellM) resolution_m *= 2.0;
  if (!fits()) {
    throw UsageError("the map would be " + extent_text(size.x(), size.y()) + " at " +
                     number_text(resolution_m) +
                     " m a cell, which is too large; lower max_range_m if some ranges are wrong");
  }
  return frame_covering(bounds.low, bounds.high, resolution_m, resolution_m);
}

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

ScanBeams beams_on_grid(const PosedScan& posed, const GridFrame& frame,
                        const OccupancyOptions& options, BeamTable& table) {
  ScanBeams result;
  if (!usable(posed)) return result;
  result.beams.reserve(posed.scan->ranges_m.size());
  for_each_beam(posed, options, table, [&](const Beam& beam) {
    const GridBeam segment{grid_point_of(frame, beam.start), grid_point_of(frame, beam.end),
                           beam.hit};
    // Neighbours that end in one cell cross the same cells.
    if (!result.beams.empty() && result.beams.back().hit == segment.hit &&
        cell_of(result.beams.back().end) == cell_of(segment.end)) {
      return;
    }
    result.include(cell_of(segment.start));
    result.include(cell_of(segment.end));
    result.beams.push_back(segment);
  });
  skip_shared_rows(result.beams);
  return result;
}

/// How a cell changes, in log-odds.
struct Updates {
  float hit;
  float miss;
  float limit;
};

/// Calls visit(i) for every bit i that is set.
template <typename Visit>
void for_each_bit(std::uint64_t bits, Visit&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

/// Inserts the part of a scan that lies in rows [first_row, end_row). End points win over what other beams passed.
void insert_scan(const ScanBeams& scan, int first_row, int end_row, const Updates& updates,
                 ScanRaster& raster, OccupancyMap& map) {
  if (scan.low.row >= end_row || scan.high.row < first_row) return;
  raster.start({scan.low.column, std::max(scan.low.row, first_row)},
               {scan.high.column, std::min(scan.high.row, end_row - 1)});
  for (const GridBeam& beam : scan.beams) {
    const Cell end = cell_of(beam.end);
    if (beam.hit && end.row >= first_row && end.row < end_row) raster.mark_hit(end);
    const bool up = beam.end.y >= beam.start.y;
    walk_ray_rows(beam.start, beam.end, up ? std::max(first_row, beam.walked_from_row) : first_row,
                  up ? end_row : std::min(end_row, beam.walked_from_row + 1),
                  [&](int row, int first_column, int last_column) {
                    raster.mark_passed(row, first_column, last_column);
                  });
  }
  const auto [hit_odds, miss_odds, limit] = updates;
  raster.finish([&, hit_odds = hit_odds, miss_odds = miss_odds, limit = limit](
                    int row, int column, std::uint64_t passed, std::uint64_t hit) {
    const std::size_t index = map.log_odds.frame().index_of({column, row});
    float* const log_odds = map.log_odds.cells().data() + index;
    std::uint8_t* const observed = map.observed.cells().data() + index;
    for_each_bit(passed, [&](std::size_t i) {
      log_odds[i] = std::max(log_odds[i] + miss_odds, -limit);
      observed[i] = 1;
    });
    for_each_bit(hit, [&](std::size_t i) {
      log_odds[i] = std::min(log_odds[i] + hit_odds, limit);
      observed[i] = 1;
    });
  });
}

/// Shares the grid between threads by bands of rows. Every cell sees the scans in their order whatever the bands are,
/// so the result does not depend on them.
void insert_batch(const std::vector<ScanBeams>& batch, const Updates& updates, Threads threads,
                  OccupancyMap& map) {
  const int workers = threads.resolved();
  const int rows = map.log_odds.frame().rows;
  const int bands = workers == 1 ? 1 : std::min(rows, 4 * workers);
  const auto edge = [&](std::size_t band) {
    return static_cast<int>(static_cast<std::int64_t>(rows) * static_cast<std::int64_t>(band) /
                            bands);
  };
  parallel_for(static_cast<std::size_t>(bands), threads, [&](std::size_t band) {
    ScanRaster raster;
    for (const ScanBeams& scan : batch)
      insert_scan(scan, edge(band), edge(band + 1), updates, raster, map);
  });
}

void insert_all(std::span<const PosedScan> scans, const OccupancyOptions& options, Threads threads,
                OccupancyMap& map) {
  const Updates updates{log_odds_of(options.hit_probability), log_odds_of(options.miss_probability),
                        log_odds_of(options.clamp_probability)};
  std::size_t first = 0;
  while (first < scans.size()) {
    std::size_t end = first;
    std::size_t beams = 0;
    while (end < scans.size() && beams < kBeamsPerBatch) {
      beams += scans[end].scan == nullptr ? 0 : scans[end].scan->ranges_m.size();
      ++end;
    }
    std::vector<ScanBeams> batch(end - first);
    parallel_for(
        (batch.size() + kScansPerTask - 1) / kScansPerTask, threads, [&](std::size_t task) {
          BeamTable table;
          const std::size_t task_end = std::min((task + 1) * kScansPerTask, batch.size());
          for (std::size_t i = task * kScansPerTask; i < task_end; ++i) {
            batch[i] = beams_on_grid(scans[first + i], map.log_odds.frame(), options, table);
          }
        });
    insert_batch(batch, updates, threads, map);
    first = end;
  }
}

/// Frees every cell whose centre lies within the radius of the segment between two positions of the robot.
void free_swept_cells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double radius_m,
                      float log_odds, OccupancyMap& map) {
  const GridFrame& frame = map.log_odds.frame();
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
      map.log_odds[cell] = std::min(map.log_odds[cell], log_odds);
      map.observed[cell] = 1;
    }
  }
}

/// Where the robot stood, nothing fixed can be. Done last, so that no echo of the robot itself stays.
void free_footprints(std::span<const PosedScan> scans, double radius_m, float log_odds,
                     OccupancyMap& map) {
  const GridFrame& frame = map.log_odds.frame();
  const PosedScan* last = nullptr;
  for (const PosedScan& posed : scans) {
    if (!usable(posed)) continue;
    const Eigen::Vector2d position = posed.map_T_robot.translation();
    const Eigen::Vector2d before = last == nullptr ? position : last->map_T_robot.translation();
    const double moved_m = (position - before).norm();
    // A robot that stands still need not be drawn again; a twentieth of a cell changes nothing that matters.
    if (last != nullptr && moved_m < 0.05 * frame.resolution) continue;
    free_swept_cells(moved_m <= kMostSweepM ? before : position, position, radius_m, log_odds, map);
    last = &posed;
  }
}

}  // namespace

double OccupancyMap::probability(Cell cell) const {
  return 1.0 / (1.0 + std::exp(-static_cast<double>(log_odds[cell])));
}

OccupancyMap build_occupancy_map(std::span<const PosedScan> scans, double footprint_radius_m,
                                 const OccupancyOptions& options, Threads threads) {
  const Bounds bounds = bounds_of(scans, footprint_radius_m, options, threads);
  const GridFrame frame = frame_of(bounds, options);
  OccupancyMap map{Grid<float>(frame), Grid<std::uint8_t>(frame)};
  insert_all(scans, options, threads, map);
  free_footprints(scans, footprint_radius_m, -log_odds_of(options.clamp_probability), map);
  return map;
}

std::optional<std::string> coarser_than_asked(const OccupancyMap& map,
                                              const OccupancyOptions& options) {
  const GridFrame& frame = map.log_odds.frame();
  if (map.log_odds.empty() || frame.resolution <= options.resolution_m) return {};
  return "the map's cells are " + number_text(frame.resolution) + " m wide, not " +
         number_text(options.resolution_m) + " m as asked: so many for " +
         extent_text(frame.columns * frame.resolution, frame.rows * frame.resolution) +
         " would take too much memory; lower max_range_m if some ranges are wrong";
}

}  // namespace loopstone
