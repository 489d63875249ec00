#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "grid/cell_ray.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/grid/ray.hpp"

// Rays, however they are given, as blocks of CellRay.
namespace loopstone {

inline constexpr std::size_t kRayBlock = 128;

inline void require_positive_range(double max_range_m) {
  if (!(max_range_m > 0.0 && max_range_m < kNoRange)) {
    throw UsageError("the greatest range of a ray caster must be positive and finite");
  }
}

inline void require_room(std::size_t rays, std::size_t ranges) {
  if (rays != ranges) throw UsageError("a ray caster needs room for one range a ray");
}

/// Calls cast(const CellRay* rays, std::size_t count, float* ranges_m) for the rays in turn, at
/// most kRayBlock at once.
template <typename Cast>
void for_each_block(const CellRaySpace& space, std::span<const Ray> rays, std::span<float> ranges_m,
                    Cast&& cast) {
  require_room(rays.size(), ranges_m.size());
  std::array<CellRay, kRayBlock> block;
  for (std::size_t begin = 0; begin < rays.size(); begin += kRayBlock) {
    const std::size_t count = std::min(kRayBlock, rays.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      const Ray& ray = rays[begin + i];
      block[i] = space.ray(ray.origin.x(), ray.origin.y(), ray.direction.x(), ray.direction.y());
    }
    cast(block.data(), count, ranges_m.data() + begin);
  }
}

/// Directions of beams, by the angle-sum formulas: a cosine and a sine for each pose and for each
/// beam, not for each pair.
struct BeamDirections {
  std::vector<double> cosines{};
  std::vector<double> sines{};

  explicit BeamDirections(std::span<const double> angles_rad) {
    for (const double angle : angles_rad) {
      cosines.push_back(std::cos(angle));
      sines.push_back(std::sin(angle));
    }
  }
};

template <typename Cast>
void for_each_block(const CellRaySpace& space, const ScanRays& rays, std::span<float> ranges_m,
                    Cast&& cast) {
  require_room(rays.size(), ranges_m.size());
  const BeamDirections beams(rays.angles_rad);
  const std::size_t beam_count = beams.cosines.size();
  std::array<CellRay, kRayBlock> block;
  std::size_t count = 0;
  std::size_t done = 0;
  const auto cast_block = [&] {
    cast(block.data(), count, ranges_m.data() + done);
    done += count;
    count = 0;
  };
  for (const Pose2& map_T_lidar : rays.map_T_lidar) {
    const double c = std::cos(map_T_lidar.yaw);
    const double s = std::sin(map_T_lidar.yaw);
    for (std::size_t k = 0; k < beam_count; ++k) {
      block[count++] =
          space.ray(map_T_lidar.x, map_T_lidar.y, c * beams.cosines[k] - s * beams.sines[k],
                    s * beams.cosines[k] + c * beams.sines[k]);
      if (count == kRayBlock) cast_block();
    }
  }
  cast_block();
}

}  // namespace loopstone
