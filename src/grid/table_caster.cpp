#include "loopstone/grid/table_caster.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <memory_resource>
#include <numbers>
#include <vector>

#include "grid/ray_batches.hpp"
#include "loopstone/grid/sphere_caster.hpp"

namespace loopstone {
namespace {

// A cell's ranges stand side by side, one a heading. Cells come in tiles of 4 x 4, so that the list
// of tiles stays in the cache: a tile is there when rays start anywhere in it.
constexpr int kTileBits = 2;
constexpr int kTileSide = 1 << kTileBits;
constexpr int kTileCells = kTileSide * kTileSide;
constexpr std::uint32_t kNoTile = std::numeric_limits<std::uint32_t>::max();

// Codes of ranges: 0 in an occupied cell, where the range is 0 wherever a ray starts; k: k quanta.
constexpr std::uint16_t kInWall = 0;
constexpr std::uint16_t kNoHit = std::numeric_limits<std::uint16_t>::max();
constexpr int kLargestCode = kNoHit - 1;

constexpr std::size_t kCacheLine = 64;

/// A part of the circle as a fraction of 2^32: angles add without wrapping.
using Turn = std::uint32_t;
constexpr double kTurnError = 1e-5;  ///< of a direction's angle [rad]
constexpr double kTurnsPerRadian = 0.5 * std::numbers::inv_pi * 4294967296.0;

/// Any number of turns; 0 for what is not a number.
Turn turn_of(double angle_rad) {
  constexpr double kCircle = 4294967296.0;
  const double turns = std::fmod(angle_rad * kTurnsPerRadian, kCircle);
  return std::isfinite(turns) ? static_cast<Turn>(static_cast<std::int64_t>(turns)) : 0;
}

/// The angle of a direction, to within kTurnError. Source: Abramowitz and Stegun 1964, 4.4.49, in
/// single precision.
Turn turn_of(double dx, double dy) {
  const auto x = static_cast<float>(dx);
  const auto y = static_cast<float>(dy);
  const float along = std::abs(x);
  const float across = std::abs(y);
  const float large = std::max(along, across);
  const float ratio = std::min(along, across) / std::max(large, 1e-30F);
  const float square = ratio * ratio;
  float angle = 0.0028662257F;
  angle = angle * square - 0.0161657367F;
  angle = angle * square + 0.0429096138F;
  angle = angle * square - 0.0752896400F;
  angle = angle * square + 0.1065626393F;
  angle = angle * square - 0.1420889944F;
  angle = angle * square + 0.1999355085F;
  angle = angle * square - 0.3333314528F;
  angle = (angle * square + 1.0F) * ratio;
  constexpr auto kHalfPi = static_cast<float>(0.5 * std::numbers::pi);
  constexpr auto kWholePi = static_cast<float>(std::numbers::pi);
  angle = across > along ? kHalfPi - angle : angle;
  angle = x < 0.0F ? kWholePi - angle : angle;
  angle = y < 0.0F ? -angle : angle;
  angle = std::isnan(angle) ? 0.0F : angle;
  return static_cast<Turn>(static_cast<std::int64_t>(angle * static_cast<float>(kTurnsPerRadian)));
}

bool within(double value, double low, double high) { return value >= low && value < high; }

}  // namespace

struct TableCaster::Tables {
  SphereCaster tracer;  ///< for rays that start elsewhere
  GridFrame frame;
  double max_range_m;
  float quantum_m;
  std::uint32_t headings;
  Turn half_step;
  std::size_t tile_pitch = 0;
  std::vector<std::uint32_t> tiles{};
  std::pmr::vector<std::uint16_t> codes;
  std::vector<Eigen::Vector2f> directions{};  ///< of the headings

  [[nodiscard]] std::uint32_t bin_of(Turn turn) const {
    return static_cast<std::uint32_t>(
        (std::uint64_t{static_cast<Turn>(turn + half_step)} * headings) >> 32);
  }

  /// Where in the table a ray starts.
  struct Start {
    std::size_t first_code = 0;  ///< of its cell
    Eigen::Vector2f offset;      ///< from the cell's centre [m]
    bool tabulated = false;
  };
  [[nodiscard]] Start start_at(double x, double y) const {
    const double column_real = (x - frame.origin.x()) / frame.resolution;
    const double row_real = (y - frame.origin.y()) / frame.resolution;
    if (!within(column_real, 0.0, frame.columns) || !within(row_real, 0.0, frame.rows)) return {};
    const auto column = static_cast<std::uint32_t>(column_real);
    const auto row = static_cast<std::uint32_t>(row_real);
    const std::uint32_t tile = tiles[(row >> kTileBits) * tile_pitch + (column >> kTileBits)];
    if (tile == kNoTile) return {};
    const std::uint32_t in_tile =
        ((row & (kTileSide - 1)) << kTileBits) + (column & (kTileSide - 1));
    return {(std::size_t{tile} * kTileCells + in_tile) * headings,
            {static_cast<float>((column_real - column - 0.5) * frame.resolution),
             static_cast<float>((row_real - row - 0.5) * frame.resolution)},
            true};
  }

  [[nodiscard]] float range_of(const Start& start, std::uint32_t bin) const {
    const std::uint16_t code = codes[start.first_code + bin];
    const float from_centre = static_cast<float>(code) * quantum_m;
    const float range = std::max(from_centre - start.offset.dot(directions[bin]), 0.0F);
    const bool in_sight = code != kNoHit && range <= static_cast<float>(max_range_m);
    return code == kInWall ? 0.0F : in_sight ? range : static_cast<float>(kNoRange);
  }

  void choose_tiles(const Grid<std::uint8_t>& occupied, const Grid<std::uint8_t>& origins);
  void fill(const SphereCaster& filler, Threads threads);
  void fill_tile(const SphereCaster& filler, std::size_t tile_index);
};

void TableCaster::Tables::choose_tiles(const Grid<std::uint8_t>& occupied,
                                       const Grid<std::uint8_t>& origins) {
  const auto tile_columns = static_cast<std::size_t>((frame.columns + kTileSide - 1) / kTileSide);
  const auto tile_rows = static_cast<std::size_t>((frame.rows + kTileSide - 1) / kTileSide);
  tile_pitch = tile_columns;
  tiles.assign(tile_columns * tile_rows, kNoTile);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      if (occupied[cell] != 0 || (!origins.empty() && origins[cell] == 0)) continue;
      tiles[static_cast<std::size_t>(row >> kTileBits) * tile_pitch +
            static_cast<std::size_t>(column >> kTileBits)] = 0;
    }
  }
  std::uint32_t count = 0;
  for (std::uint32_t& tile : tiles) {
    if (tile != kNoTile) tile = count++;
  }
  codes.resize(std::size_t{count} * kTileCells * headings, kNoHit);
}

void TableCaster::Tables::fill_tile(const SphereCaster& filler, std::size_t tile_index) {
  const auto first_column = static_cast<int>(tile_index % tile_pitch) * kTileSide;
  const auto first_row = static_cast<int>(tile_index / tile_pitch) * kTileSide;
  std::vector<double> angles_rad;
  for (std::uint32_t k = 0; k < headings; ++k) {
    angles_rad.push_back(2.0 * std::numbers::pi * k / headings);
  }
  std::vector<float> ranges_m(headings);
  for (int in_tile = 0; in_tile < kTileCells; ++in_tile) {
    const Cell cell{first_column + (in_tile & (kTileSide - 1)), first_row + (in_tile >> kTileBits)};
    const Eigen::Vector2d centre = frame.centre_of(cell);
    const Pose2 pose{centre.x(), centre.y(), 0.0};
    filler.ranges(ScanRays{{&pose, 1}, angles_rad}, ranges_m);
    std::uint16_t* const cell_codes =
        &codes[(std::size_t{tiles[tile_index]} * kTileCells + static_cast<std::size_t>(in_tile)) *
               headings];
    for (std::uint32_t k = 0; k < headings; ++k) {
      const float quanta = std::round(ranges_m[k] / quantum_m);
      cell_codes[k] =
          quanta <= static_cast<float>(kLargestCode) ? static_cast<std::uint16_t>(quanta) : kNoHit;
    }
  }
}

void TableCaster::Tables::fill(const SphereCaster& filler, Threads threads) {
  for (std::uint32_t k = 0; k < headings; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / headings;
    directions.emplace_back(static_cast<float>(std::cos(angle)),
                            static_cast<float>(std::sin(angle)));
  }
  parallel_for(tiles.size(), threads, [&](std::size_t tile) {
    if (tiles[tile] != kNoTile) fill_tile(filler, tile);
  });
}

TableCaster::TableCaster(const Grid<std::uint8_t>& occupied, double max_range_m,
                         const Grid<std::uint8_t>& origins, const TableCasterOptions& options,
                         Threads threads, std::pmr::memory_resource* memory) {
  require_positive_range(max_range_m);
  const GridFrame& frame = occupied.frame();
  if (!origins.empty() &&
      (origins.frame().columns != frame.columns || origins.frame().rows != frame.rows)) {
    throw UsageError("a table of ranges needs the cells where rays start on the grid of the map");
  }
  if (options.headings < 4) throw UsageError("a table of ranges needs at least 4 headings");
  // The centre of a cell may be half a diagonal farther from a wall than the ray's origin is.
  const double table_range_m = max_range_m + frame.resolution;
  const auto headings = static_cast<std::uint32_t>(options.headings);
  auto tables = std::make_shared<Tables>(
      Tables{.tracer = SphereCaster(occupied, max_range_m, threads),
             .frame = frame,
             .max_range_m = max_range_m,
             .quantum_m = static_cast<float>(table_range_m / kLargestCode),
             .headings = headings,
             .half_step = static_cast<Turn>((std::uint64_t{1} << 31) / headings),
             .codes = std::pmr::vector<std::uint16_t>(
                 memory != nullptr ? memory : std::pmr::get_default_resource())});
  tables->choose_tiles(occupied, origins);
  tables->fill(SphereCaster(occupied, table_range_m, threads), threads);
  tables_ = std::move(tables);
}

double TableCaster::range(const Ray& ray) const {
  float range_m = 0.0F;
  ranges(std::span<const Ray>(&ray, 1), std::span<float>(&range_m, 1));
  return static_cast<double>(range_m);
}

void TableCaster::ranges(std::span<const Ray> rays, std::span<float> ranges_m) const {
  require_room(rays.size(), ranges_m.size());
  const Tables& tables = *tables_;
  std::array<Tables::Start, kRayBlock> starts;
  std::array<std::uint32_t, kRayBlock> bins;
  for (std::size_t begin = 0; begin < rays.size(); begin += kRayBlock) {
    const std::size_t count = std::min(kRayBlock, rays.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {  // ask memory for all of them, then look
      const Ray& ray = rays[begin + i];
      starts[i] = tables.start_at(ray.origin.x(), ray.origin.y());
      bins[i] = tables.bin_of(turn_of(ray.direction.x(), ray.direction.y()));
      if (starts[i].tabulated) __builtin_prefetch(&tables.codes[starts[i].first_code + bins[i]]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (starts[i].tabulated) {
        ranges_m[begin + i] = tables.range_of(starts[i], bins[i]);
      } else {
        ranges_m[begin + i] = static_cast<float>(tables.tracer.range(rays[begin + i]));
      }
    }
  }
}

void TableCaster::ranges(const ScanRays& rays, std::span<float> ranges_m) const {
  require_room(rays.size(), ranges_m.size());
  const Tables& tables = *tables_;
  const std::size_t beam_count = rays.angles_rad.size();
  std::vector<Turn> beam_turns;
  for (const double angle : rays.angles_rad) beam_turns.push_back(turn_of(angle));
  const auto start_of = [&](std::size_t pose) {
    auto start = tables.start_at(rays.map_T_lidar[pose].x, rays.map_T_lidar[pose].y);
    if (start.tabulated) {
      constexpr std::size_t kStep = kCacheLine / sizeof(std::uint16_t);
      for (std::size_t k = 0; k < tables.headings; k += kStep) {
        __builtin_prefetch(&tables.codes[start.first_code + k]);
      }
    }
    return start;
  };
  constexpr std::size_t kAhead = 2;
  std::array<Tables::Start, kAhead + 1> starts;
  const std::size_t poses = rays.map_T_lidar.size();
  for (std::size_t pose = 0; pose < std::min(kAhead, poses); ++pose) starts[pose] = start_of(pose);
  for (std::size_t pose = 0; pose < poses; ++pose) {
    if (pose + kAhead < poses) starts[(pose + kAhead) % starts.size()] = start_of(pose + kAhead);
    const Tables::Start start = starts[pose % starts.size()];
    float* const out = ranges_m.data() + pose * beam_count;
    if (!start.tabulated) {
      tables.tracer.ranges(ScanRays{rays.map_T_lidar.subspan(pose, 1), rays.angles_rad},
                           {out, beam_count});
      continue;
    }
    const Turn heading = turn_of(rays.map_T_lidar[pose].yaw);
    for (std::size_t k = 0; k < beam_count; ++k) {
      out[k] = tables.range_of(start, tables.bin_of(heading + beam_turns[k]));
    }
  }
}

double TableCaster::max_range_m() const { return tables_->max_range_m; }

std::size_t TableCaster::memory_bytes() const {
  return tables_->tracer.memory_bytes() + tables_->tiles.size() * sizeof(std::uint32_t) +
         tables_->codes.size() * sizeof(std::uint16_t) +
         tables_->directions.size() * sizeof(Eigen::Vector2f);
}

TableCaster::Answered TableCaster::answered(const Ray& ray) const {
  const Tables& tables = *tables_;
  const Tables::Start start = tables.start_at(ray.origin.x(), ray.origin.y());
  if (!start.tabulated) return {ray, 0.0, false};
  const std::uint32_t bin = tables.bin_of(turn_of(ray.direction.x(), ray.direction.y()));
  const double angle = 2.0 * std::numbers::pi * bin / tables.headings;
  const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d centre = tables.frame.centre_of(tables.frame.cell_of(ray.origin));
  return {{centre, direction}, (ray.origin - centre).dot(direction), true};
}

double TableCaster::stray_m(double range_m) const {
  return std::numbers::sqrt2 * 0.5 * tables_->frame.resolution +
         range_m * (std::numbers::pi / tables_->headings + kTurnError) + range_quantum_m();
}

double TableCaster::range_quantum_m() const { return static_cast<double>(tables_->quantum_m); }

}  // namespace loopstone
