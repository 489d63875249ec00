#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <span>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/ray.hpp"

namespace loopstone {

struct TableCasterOptions {
  int headings = 384;  ///< evenly around the circle
};

/// Casts rays by looking them up: the ranges from the centres of cells at evenly spaced headings,
/// in 16 bits.
///
/// A ray is answered with the line through the centre of its cell at the nearest tabulated heading,
/// started abreast of the ray's origin. That answer is exact up to half a quantum
/// (range_quantum_m). The line strays from the ray by at most stray_m(r) at range r: half a cell's
/// diagonal, plus r times half the step between headings. So a hit is reported where an occupied
/// cell lies within that of the ray. A range itself can differ by any amount: where one line just
/// misses a corner and the other does not.
///
/// Immutable and thread-safe; copies share the table. Memory: 2 bytes a heading and cell, for cells
/// where rays start.
/// Cost: one look-up. That is about 5 ns for a beam of a scan, whose ranges lie side by side in
/// memory, and 50 ns or more for a ray from anywhere, which waits for memory.
/// Source: Walsh and Karaman 2018, "CDDT: fast approximate 2D ray casting for accelerated
/// localization", section III.
class TableCaster {
 public:
  /// \param occupied     cells that stop a ray: not 0
  /// \param max_range_m  rays see nothing beyond
  /// \param origins      where rays start: cells that are not 0; empty: wherever the grid is not
  ///                     occupied. Rays from other places are traced (SphereCaster), so they are
  ///                     answered exactly, only slower.
  /// \param memory       for the table, outlives the caster; nullptr: the default one. Random
  ///                     look-ups are about twice as fast in large pages, because finding a small
  ///                     one takes as long as the look-up
  /// Throws UsageError when the greatest range is not positive and finite, when `origins` has
  /// another size than `occupied`, or for fewer than 4 headings.
  TableCaster(const Grid<std::uint8_t>& occupied, double max_range_m,
              const Grid<std::uint8_t>& origins = {}, const TableCasterOptions& options = {},
              Threads threads = {}, std::pmr::memory_resource* memory = nullptr);

  /// [m]; +inf: nothing within the greatest range.
  [[nodiscard]] double range(const Ray& ray) const;
  /// Throws UsageError, as the call below, when `ranges_m` has another size than the rays.
  void ranges(std::span<const Ray> rays, std::span<float> ranges_m) const;
  void ranges(const ScanRays& rays, std::span<float> ranges_m) const;

  [[nodiscard]] double max_range_m() const;
  [[nodiscard]] std::size_t memory_bytes() const;

  /// The line that is answered in place of a ray.
  struct Answered {
    Ray ray_from_centre;  ///< the ray itself where the table has nothing on its cell
    double ahead_m =
        0.0;  ///< the answer starts so far ahead of the centre, abreast of the ray's origin
    bool tabulated = false;
  };
  [[nodiscard]] Answered answered(const Ray& ray) const;
  [[nodiscard]] double stray_m(double range_m) const;
  [[nodiscard]] double range_quantum_m() const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace loopstone
