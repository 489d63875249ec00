#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "loopstone/registration/scan_matcher.hpp"
#include "registration/direction_index.hpp"

namespace loopstone {

namespace {

/// Surfaces in directions farther apart than this many bins have nothing between them.
constexpr int kGreatestGap = kDirectionBins / 24;

/// Which surface lies in which direction: between two neighbours, the nearer one.
class DirectionIndex {
 public:
  DirectionIndex(std::span<const SurfacePoint> surfaces, const Eigen::Vector2d& lidar)
      : index_(kDirectionBins, kNothing) {
    assert(surfaces.size() <= std::numeric_limits<std::int16_t>::max());
    std::vector<int> bins;
    bins.reserve(surfaces.size());
    for (const SurfacePoint& surface : surfaces) {
      const Eigen::Vector2d beam = surface.position.cast<double>() - lidar;
      bins.push_back(direction_bin(beam.x(), beam.y()));
    }
    for (std::size_t i = 1; i < bins.size(); ++i) fill_between(bins, i - 1, i);
    if (bins.size() > 2) fill_between(bins, bins.size() - 1, 0);  // a scanner that sees all round
    for (std::size_t i = 0; i < bins.size(); ++i) set(bins[i], i);
  }

  [[nodiscard]] std::vector<std::int16_t> take() { return std::move(index_); }

 private:
  static constexpr std::int16_t kNothing = -1;

  void set(int bin, std::size_t surface) {
    index_[static_cast<std::size_t>(bin & (kDirectionBins - 1))] =
        static_cast<std::int16_t>(surface);
  }
  /// The shorter way round.
  void fill_between(const std::vector<int>& bins, std::size_t from, std::size_t to) {
    const int ahead = (bins[to] - bins[from]) & (kDirectionBins - 1);
    const int step = ahead <= kDirectionBins / 2 ? 1 : -1;
    const int gap = step > 0 ? ahead : kDirectionBins - ahead;
    if (gap > kGreatestGap) return;
    for (int k = 1; k < gap; ++k) set(bins[from] + step * k, 2 * k < gap ? from : to);
  }

  std::vector<std::int16_t> index_;
};

}  // namespace

ScanView view_scan(const LaserScan& scan, const Pose2& robot_T_lidar, const Tangent2& velocity,
                   BeamTable& beams, const SurfaceOptions& options) {
  ScanView view;
  view.surfaces = surface_points(scan, robot_T_lidar, velocity, options, beams);
  view.lidar = robot_T_lidar.translation();
  view.beam_spacing_rad = std::abs(scan.angle_increment_rad);
  view.surface_spacing_m = options.spacing_m;
  view.support_m = options.support_m;
  view.by_direction = DirectionIndex(view.surfaces, view.lidar).take();
  return view;
}

}  // namespace loopstone
