#include "loopstone/mapping/occupancy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"
#include "mapping/scan_drawing.hpp"

namespace loopstone {
namespace {

/// Beams are kept for so many at a time, which bounds the memory for any length of log.
constexpr std::size_t kBeamsPerBatch = std::size_t{1} << 18;
/// Scans that one task of the preparation handles.
constexpr std::size_t kScansPerTask = 64;
/// A map that is too large is drawn with cells up to so wide.
constexpr double kWidestCellM = 1.0;
/// Along one side.
constexpr double kMostColumns = 1e6;

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

/// Inserts the part of a scan that lies in rows [first_row, end_row).
void insert_scan(const ScanBeams& scan, int first_row, int end_row, const CellUpdates& updates,
                 ScanRaster& raster, OccupancyMap& map) {
  raster_scan(scan, first_row, end_row, raster,
              [&](int row, int column, std::uint64_t passed, std::uint64_t hit) {
                const std::size_t index = map.log_odds.frame().index_of({column, row});
                updates.apply(passed, hit, map.log_odds.cells().data() + index,
                              map.observed.cells().data() + index);
              });
}

/// Shares the grid between threads by bands of rows. Every cell sees the scans in their order
/// whatever the bands are, so the result does not depend on them.
void insert_batch(const std::vector<ScanBeams>& batch, const CellUpdates& updates, Threads threads,
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
  const CellUpdates updates(options);
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

/// Where the robot stood, nothing fixed can be. Done last, so that no echo of the robot itself
/// stays.
void free_footprints(std::span<const PosedScan> scans, double radius_m, float log_odds,
                     OccupancyMap& map) {
  const GridFrame& frame = map.log_odds.frame();
  std::optional<Eigen::Vector2d> before;
  for (const PosedScan& posed : scans) {
    if (!usable(posed)) continue;
    sweep_footprint(frame, posed.map_T_robot.translation(), radius_m, before, [&](Cell cell) {
      map.log_odds[cell] = std::min(map.log_odds[cell], log_odds);
      map.observed[cell] = 1;
    });
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
