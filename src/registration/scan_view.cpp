#include <cmath>
#include <span>

#include "loopstone/registration/scan_matcher.hpp"
#include "registration/direction_index.hpp"

namespace loopstone {

namespace {

/// Surfaces in directions farther apart than this many bins have nothing between them.
constexpr int kGreatestGap = kDirectionBins / 24;

/// Which surface lies in which direction: between two neighbours, the nearer one.
std::vector<std::int16_t> index_directions(std::span<const SurfacePoint> surfaces,
                                           const Eigen::Vector2d& lidar) {
  std::vector<std::int16_t> index(kDirectionBins, -1);
  int last_bin = -1;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::Vector2d beam = surfaces[i].position.cast<double>() - lidar;
    const int bin = direction_bin(beam.x(), beam.y());
    if (last_bin >= 0) {
      // The shorter way round from the surface before to this one.
      const int ahead = (bin - last_bin) & (kDirectionBins - 1);
      const int step = ahead <= kDirectionBins / 2 ? 1 : -1;
      const int gap = step > 0 ? ahead : kDirectionBins - ahead;
      if (gap <= kGreatestGap) {
        for (int k = 1; k < gap; ++k) {
          const int between = (last_bin + step * k) & (kDirectionBins - 1);
          index[static_cast<std::size_t>(between)] =
              static_cast<std::int16_t>(2 * k < gap ? i - 1 : i);
        }
      }
    }
    index[static_cast<std::size_t>(bin)] = static_cast<std::int16_t>(i);
    last_bin = bin;
  }
  return index;
}

}  // namespace

ScanView view_scan(const LaserScan& scan, const Pose2& robot_T_lidar, const Tangent2& velocity,
                   BeamTable& beams, const SurfaceOptions& options) {
  ScanView view;
  view.surfaces = surface_points(scan, robot_T_lidar, velocity, options, beams);
  view.lidar = robot_T_lidar.translation();
  view.beam_spacing_rad = std::abs(scan.angle_increment_rad);
  view.surface_spacing_m = options.spacing_m;
  view.by_direction = index_directions(view.surfaces, view.lidar);
  return view;
}

}  // namespace loopstone
