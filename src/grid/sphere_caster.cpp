#include "loopstone/grid/sphere_caster.hpp"

#include <array>
#include <cmath>

#include "grid/cell_ray.hpp"
#include "grid/ray_batches.hpp"
#include "loopstone/grid/distance_transform.hpp"

namespace loopstone {
namespace {

// Codes of cells: 0 occupied, 1 an occupied cell is less than kLeastLeap away, and from there up
// how far a ray that is anywhere in the cell may leap: exactly in eighths of a cell up to 16 cells,
// then in whole cells.
constexpr std::uint8_t kOccupied = 0;
constexpr std::uint8_t kNear = 1;
constexpr int kUnitsPerCell = 8;
constexpr int kLeastLeap = kUnitsPerCell;  // [units]
constexpr int kFineCodes = 128;

/// How far to leap from cells of each code [units].
constexpr std::array<std::uint16_t, 256> leaps() {
  std::array<std::uint16_t, 256> leap{};
  for (int code = 2; code < 256; ++code) {
    const int fine = kLeastLeap + code - 2;
    const int coarse = kLeastLeap + kFineCodes + (code - 2 - kFineCodes) * kUnitsPerCell;
    leap[static_cast<std::size_t>(code)] =
        static_cast<std::uint16_t>(code - 2 <= kFineCodes ? fine : coarse);
  }
  return leap;
}
constexpr std::array<std::uint16_t, 256> kLeaps = leaps();

/// The greatest code whose leap is at most the gap.
std::uint8_t code_of(double gap_cells) {
  const double units = gap_cells * kUnitsPerCell + 1e-3;  // distances are single precision
  if (units < kLeastLeap) return kNear;
  const auto next = std::upper_bound(kLeaps.begin() + 2, kLeaps.end(), units,
                                     [](double value, std::uint16_t leap) { return value < leap; });
  return static_cast<std::uint8_t>(next - kLeaps.begin() - 1);
}

/// How far any point of a cell is at least from any point of an occupied cell, as codes. The gap
/// between two cells that are i columns and j rows apart is |(max(i - 1, 0), max(j - 1, 0))|: the
/// distance between centres when the occupied one is let grow by its eight neighbours.
BorderedCells leap_codes(const Grid<std::uint8_t>& occupied, Threads threads) {
  const GridFrame& frame = occupied.frame();
  GridFrame wide = frame;
  wide.columns += 2;
  wide.rows += 2;
  Grid<std::uint8_t> grown(wide);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (occupied[{column, row}] == 0) continue;
      for (int r = row; r < row + 3; ++r) {
        for (int c = column; c < column + 3; ++c) grown[{c, r}] = 1;
      }
    }
  }
  wide.resolution = 1.0;
  Grid<std::uint8_t> in_cells(wide);
  in_cells.cells() = std::move(grown.cells());
  const Grid<float> gaps = distance_transform(in_cells, threads);
  BorderedCells codes(frame, kNear);
  for (std::size_t i = 0; i < codes.bytes.size(); ++i) {
    codes.bytes[i] = code_of(static_cast<double>(gaps.cells()[i]));
  }
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (occupied[{column, row}] == 0) continue;
      codes.bytes[static_cast<std::size_t>(codes.index_of(column, row))] = kOccupied;
    }
  }
  return codes;
}

/// A ray that leaps: its position, in 2^-32 of a cell, from the border's corner.
struct Leaper {
  std::int64_t x;
  std::int64_t y;
  std::int64_t dx;  ///< of one unit of leap
  std::int64_t dy;
  std::int64_t leapt;  ///< [units], since t = start
  std::int64_t limit;  ///< [units]
  double start;        ///< [cells]
  std::int64_t index;  ///< of the cell that it is in; its code is on the way from memory

  void look_ahead(const BorderedCells& codes) {
    index = (y >> 32) * codes.pitch + (x >> 32);
    __builtin_prefetch(codes.bytes.data() + index);
  }
};

constexpr double kFixedOne = 4294967296.0;

}  // namespace

struct SphereCaster::Tables {
  CellRaySpace space;
  BorderedCells codes;

  void cast_block(const CellRay* rays, std::size_t count, float* ranges_m) const;
  [[nodiscard]] bool walk(const CellRay& ray, double from, double& t) const;
};

namespace {

void start_leaping(const CellRay& ray, double t, const BorderedCells& codes, Leaper& leaper) {
  leaper.x = static_cast<std::int64_t>((ray.x + t * ray.dx + 1.0) * kFixedOne);
  leaper.y = static_cast<std::int64_t>((ray.y + t * ray.dy + 1.0) * kFixedOne);
  leaper.dx = static_cast<std::int64_t>(ray.dx * (kFixedOne / kUnitsPerCell));
  leaper.dy = static_cast<std::int64_t>(ray.dy * (kFixedOne / kUnitsPerCell));
  leaper.leapt = 0;
  leaper.limit = static_cast<std::int64_t>((ray.end - t) * kUnitsPerCell) + 1;
  leaper.start = t;
  leaper.look_ahead(codes);
}

}  // namespace

/// Walks until it hits (true), ends (true, +inf) or stands well off the walls again (false, t
/// there).
bool SphereCaster::Tables::walk(const CellRay& ray, double from, double& t) const {
  constexpr std::uint8_t kWellOff = 2 + kUnitsPerCell;
  CellWalk walk(ray, from, codes);
  while (true) {
    const std::uint8_t code = codes.bytes[walk.index()];
    if (code == kOccupied) {
      t = walk.t();
      return true;
    }
    if (code >= kWellOff) {
      t = walk.t();
      return false;
    }
    if (!walk.step(ray.end)) {
      t = kNoRange;
      return true;
    }
  }
}

void SphereCaster::Tables::cast_block(const CellRay* rays, std::size_t count,
                                      float* ranges_m) const {
  std::array<Leaper, kRayBlock> leapers;
  std::array<std::uint8_t, kRayBlock> leaping;
  std::array<std::uint8_t, kRayBlock> near;
  std::size_t leaping_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    ranges_m[i] = static_cast<float>(kNoRange);
    if (!(rays[i].begin <= rays[i].end)) continue;
    start_leaping(rays[i], rays[i].begin, codes, leapers[i]);
    leaping[leaping_count++] = static_cast<std::uint8_t>(i);
  }
  while (leaping_count > 0) {
    std::size_t near_count = 0;
    while (leaping_count > 0) {
      std::size_t kept = 0;
      for (std::size_t k = 0; k < leaping_count; ++k) {
        const std::uint8_t i = leaping[k];
        Leaper& at = leapers[i];
        const std::uint8_t code = codes.bytes[static_cast<std::size_t>(at.index)];
        const std::int64_t leap = kLeaps[code];
        at.x += leap * at.dx;
        at.y += leap * at.dy;
        at.leapt += leap;
        at.look_ahead(codes);
        // No branch: whichever list it belongs to, the other's entry is written over.
        const bool goes_on = at.leapt < at.limit;
        const bool is_near = code <= kNear;
        leaping[kept] = i;
        kept += static_cast<std::size_t>(goes_on && !is_near);
        near[near_count] = i;
        near_count += static_cast<std::size_t>(is_near);
      }
      leaping_count = kept;
    }
    for (std::size_t k = 0; k < near_count; ++k) {
      const std::uint8_t i = near[k];
      // A hundredth of a cell back, where the ray is in the open for sure whatever was rounded.
      const double leapt = static_cast<double>(leapers[i].leapt) * (1.0 / kUnitsPerCell);
      const double from = std::max(rays[i].begin, leapers[i].start + leapt - 0.01);
      double t = 0.0;
      if (walk(rays[i], from, t)) {
        ranges_m[i] = static_cast<float>(t * space.resolution);
      } else {
        start_leaping(rays[i], t, codes, leapers[i]);
        leaping[leaping_count++] = i;
      }
    }
  }
}

SphereCaster::SphereCaster(const Grid<std::uint8_t>& occupied, double max_range_m, Threads threads)
    : max_range_m_(max_range_m) {
  require_positive_range(max_range_m);
  tables_ = std::make_shared<const Tables>(
      Tables{{occupied.frame(), max_range_m}, leap_codes(occupied, threads)});
}

double SphereCaster::range(const Ray& ray) const {
  float range_m = 0.0F;
  ranges(std::span<const Ray>(&ray, 1), std::span<float>(&range_m, 1));
  return static_cast<double>(range_m);
}

void SphereCaster::ranges(std::span<const Ray> rays, std::span<float> ranges_m) const {
  for_each_block(tables_->space, rays, ranges_m,
                 [this](const CellRay* block, std::size_t count, float* out) {
                   tables_->cast_block(block, count, out);
                 });
}

void SphereCaster::ranges(const ScanRays& rays, std::span<float> ranges_m) const {
  for_each_block(tables_->space, rays, ranges_m,
                 [this](const CellRay* block, std::size_t count, float* out) {
                   tables_->cast_block(block, count, out);
                 });
}

std::size_t SphereCaster::memory_bytes() const { return tables_->codes.bytes.size(); }

}  // namespace loopstone
