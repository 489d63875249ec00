#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/ray.hpp"

namespace loopstone {

struct BorderedCells;
struct CellRaySpace;

/// Casts rays by walking from cell to cell: simple, exact, and what the other casters are held
/// against. Immutable and thread-safe; copies share the map. Memory: one byte a cell. Cost: about 5
/// ns a cell on the way.
/// Source: Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing".
class WalkCaster {
 public:
  /// \param occupied     cells that stop a ray: not 0
  /// \param max_range_m  rays see nothing beyond
  /// Throws UsageError when the greatest range is not positive and finite.
  WalkCaster(const Grid<std::uint8_t>& occupied, double max_range_m);

  /// [m]; +inf: nothing within the greatest range.
  [[nodiscard]] double range(const Ray& ray) const;
  /// Throws UsageError, as the call below, when `ranges_m` has another size than the rays.
  void ranges(std::span<const Ray> rays, std::span<float> ranges_m) const;
  void ranges(const ScanRays& rays, std::span<float> ranges_m) const;

  [[nodiscard]] double max_range_m() const { return max_range_m_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  double max_range_m_;
  std::shared_ptr<const CellRaySpace> space_;
  std::shared_ptr<const BorderedCells> cells_;
};

}  // namespace loopstone
