#include "loopstone/slam/wall_axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr int kBins = 90 * kWallAxes.bins_per_degree;
using Histogram = std::array<double, kBins>;

constexpr double kQuarter = 0.5 * kPi;

/// Within a quarter turn: [0, pi/2).
double in_quarter(double angle_rad) {
  const double within = angle_rad - kQuarter * std::floor(angle_rad / kQuarter);
  return within < kQuarter ? within : 0.0;
}

/// From one direction to another by the shorter way round the quarter: [-pi/4, pi/4).
double turn_between(double from_rad, double to_rad) {
  const double turn = in_quarter(to_rad - from_rad);
  return turn < 0.5 * kQuarter ? turn : turn - kQuarter;
}

int half_bins(double degrees) {
  return static_cast<int>(std::lround(degrees * kWallAxes.bins_per_degree));
}

double sum_around(const Histogram& histogram, int bin, int half) {
  double sum = 0.0;
  for (int i = -half; i <= half; ++i)
    sum += histogram[static_cast<std::size_t>((bin + i + kBins) % kBins)];
  return sum;
}

/// The bin around which most lies.
int peak_of(const Histogram& histogram, double half_deg) {
  int best = 0;
  double most = -1.0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double sum = sum_around(histogram, bin, half_bins(half_deg));
    if (sum <= most) continue;
    most = sum;
    best = bin;
  }
  return best;
}

template <typename Visit>
void for_each_direction(std::span<const Pose2> map_T_keys,
                        std::span<const std::vector<SurfacePoint>> surfaces, Visit&& visit) {
  for (std::size_t i = 0; i < std::min(map_T_keys.size(), surfaces.size()); ++i) {
    for (const SurfacePoint& surface : surfaces[i]) {
      if (!(surface.weight >= 1.0F)) continue;
      const double own = std::atan2(static_cast<double>(surface.normal.y()),
                                    static_cast<double>(surface.normal.x()));
      visit(in_quarter(own + map_T_keys[i].yaw));
    }
  }
}

double direction_of(int bin) { return (bin + 0.5) / kBins * kQuarter; }

}  // namespace

WallAxes wall_axes(std::span<const Pose2> map_T_keys,
                   std::span<const std::vector<SurfacePoint>> surfaces) {
  Histogram histogram{};
  for_each_direction(map_T_keys, surfaces, [&](double direction_rad) {
    const int bin = static_cast<int>(direction_rad / kQuarter * kBins);
    histogram[static_cast<std::size_t>(std::min(bin, kBins - 1))] += 1.0;
  });
  const double total = std::accumulate(histogram.begin(), histogram.end(), 0.0);
  if (!(total > 0.0)) return {};

  double axis_rad = direction_of(peak_of(histogram, kWallAxes.peak_half_deg));
  // The mean of those near to it, twice: the window moves onto the peak.
  for (int round = 0; round < 2; ++round) {
    double sum = 0.0;
    double count = 0.0;
    for_each_direction(map_T_keys, surfaces, [&](double direction_rad) {
      const double off = turn_between(axis_rad, direction_rad);
      if (std::abs(off) > radians(kWallAxes.fine_half_deg)) return;
      sum += off;
      count += 1.0;
    });
    if (count > 0.0) axis_rad += sum / count;
  }

  WallAxes axes{.map_yaw_rad = turn_between(0.0, axis_rad)};
  const int half = half_bins(kWallAxes.facing_half_deg);
  const auto at = std::min(static_cast<int>(in_quarter(axis_rad) / kQuarter * kBins), kBins - 1);
  axes.share = sum_around(histogram, at, half) / total;
  for (int bin = 0; bin < kBins; ++bin) {
    const double apart = turn_between(direction_of(at), direction_of(bin));
    if (std::abs(apart) < radians(kWallAxes.elsewhere_deg)) continue;
    axes.next_share = std::max(axes.next_share, sum_around(histogram, bin, half) / total);
  }
  return axes;
}

}  // namespace loopstone
