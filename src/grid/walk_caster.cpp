#include "loopstone/grid/walk_caster.hpp"

#include "grid/cell_ray.hpp"
#include "grid/ray_batches.hpp"

namespace loopstone {
namespace {

double walk_to_hit(const CellRay& ray, const BorderedCells& occupied) {
  if (!(ray.begin <= ray.end)) return kNoRange;
  CellWalk walk(ray, ray.begin, occupied);
  while (occupied.bytes[walk.index()] == 0) {
    if (!walk.step(ray.end)) return kNoRange;
  }
  return walk.t();
}

}  // namespace

WalkCaster::WalkCaster(const Grid<std::uint8_t>& occupied, double max_range_m)
    : max_range_m_(max_range_m) {
  require_positive_range(max_range_m);
  const GridFrame& frame = occupied.frame();
  space_ = std::make_shared<const CellRaySpace>(frame, max_range_m);
  auto cells = std::make_shared<BorderedCells>(frame, std::uint8_t{0});
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      cells->bytes[static_cast<std::size_t>(cells->index_of(column, row))] =
          occupied[{column, row}] != 0 ? 1 : 0;
    }
  }
  cells_ = std::move(cells);
}

double WalkCaster::range(const Ray& ray) const {
  const CellRay in_cells =
      space_->ray(ray.origin.x(), ray.origin.y(), ray.direction.x(), ray.direction.y());
  return walk_to_hit(in_cells, *cells_) * space_->resolution;
}

void WalkCaster::ranges(std::span<const Ray> rays, std::span<float> ranges_m) const {
  for_each_block(*space_, rays, ranges_m, [&](const CellRay* block, std::size_t count, float* out) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = static_cast<float>(walk_to_hit(block[i], *cells_) * space_->resolution);
    }
  });
}

void WalkCaster::ranges(const ScanRays& rays, std::span<float> ranges_m) const {
  for_each_block(*space_, rays, ranges_m, [&](const CellRay* block, std::size_t count, float* out) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = static_cast<float>(walk_to_hit(block[i], *cells_) * space_->resolution);
    }
  });
}

std::size_t WalkCaster::memory_bytes() const { return cells_->bytes.size(); }

}  // namespace loopstone
