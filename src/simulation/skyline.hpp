#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {

/// The solids around a point: the first surface at each of many bearings, from which the exact
/// range along any ray between them follows by one division.
class Skyline {
 public:
  /// Legs are numbered from here on.
  static constexpr std::uint32_t kFirstLeg = std::uint32_t{1} << 31U;

  Skyline(const SurfaceIndex& surfaces, const std::vector<Circle>& legs,
          const Eigen::Vector2d& origin, double first_bearing_rad, double step_rad, int bearings,
          double max_range_m);

  /// What a ray sees nearer than `limit_m`; nothing when that is farther.
  /// \param bearing    of the direction, in steps from the first; within [0, bearings - 1)
  /// \param direction  unit length
  [[nodiscard]] SurfaceHit nearer_than(float limit_m, float bearing,
                                       const Eigen::Vector2d& direction) const;

 private:
  [[nodiscard]] SurfaceHit look(const Eigen::Vector2d& direction) const;
  [[nodiscard]] double range_to_surface(std::uint32_t surface,
                                        const Eigen::Vector2d& direction) const;

  const SurfaceIndex& surfaces_;
  const std::vector<Circle>& legs_;
  Eigen::Vector2d origin_;
  double max_range_m_;
  std::vector<SurfaceHit> hits_{};
};

}  // namespace loopstone
