#include <algorithm>
#include <array>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "plan/plan_numbers.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

namespace {

constexpr double kQuarter = 0.5 * kPi;

/// From an axis to a line by the shorter way round the quarter: [-pi/4, pi/4].
double turn_from(double axis_rad, const WallLine& line) {
  return std::remainder(std::atan2(line.along.y(), line.along.x()) - axis_rad, kQuarter);
}

/// What a line knows of a direction. One of unknown direction knows nothing.
double weight_of(const WallLine& line) {
  const double floor_rad =
      0.5e-3;  // walls of a building are not truer than half a millimetre a metre
  return 1.0 / (line.sigma_yaw_rad * line.sigma_yaw_rad + floor_rad * floor_rad);
}

}  // namespace

std::vector<PlanAxis> find_axes(const std::vector<WallLine>& lines) {
  constexpr int kBins = 180;  // half a degree each
  constexpr int kHalf = 3;
  const double bin_rad = kQuarter / kBins;
  std::array<double, kBins> lengths{};
  double total = 0.0;
  for (const WallLine& line : lines) {
    const double turn = turn_from(0.0, line);
    const int bin = static_cast<int>(std::floor(turn / bin_rad)) + kBins;
    lengths[static_cast<std::size_t>(bin % kBins)] += line.length_m();
    total += line.length_m();
  }
  std::vector<PlanAxis> axes;
  constexpr std::size_t kMost = 6;
  while (axes.size() < kMost && total > 0.0) {
    int best = -1;
    double most = kPlan.axis_least_share * total;
    for (int bin = 0; bin < kBins; ++bin) {
      double sum = 0.0;
      for (int i = -kHalf; i <= kHalf; ++i)
        sum += lengths[static_cast<std::size_t>((bin + i + kBins) % kBins)];
      if (sum <= most) continue;
      most = sum;
      best = bin;
    }
    if (best < 0) break;
    PlanAxis axis{.yaw_rad = (best + 0.5) * bin_rad, .share = most / total};
    for (const double half_rad : {1.5 * kHalf * bin_rad, kHalf * bin_rad, 1.2 * bin_rad}) {
      double sum = 0.0;
      double weights = 0.0;
      for (const WallLine& line : lines) {
        const double off = turn_from(axis.yaw_rad, line);
        if (std::abs(off) > half_rad) continue;
        sum += weight_of(line) * off;
        weights += weight_of(line);
      }
      if (!(weights > 0.0)) break;
      axis.yaw_rad = std::remainder(axis.yaw_rad + sum / weights, kQuarter);
      axis.sigma_rad = 1.0 / std::sqrt(weights);
    }
    axes.push_back(axis);
    for (int i = -2 * kHalf; i <= 2 * kHalf; ++i)
      lengths[static_cast<std::size_t>((best + i + kBins) % kBins)] = 0.0;
  }
  return axes;
}

void square_lines(const std::vector<PlanAxis>& axes, std::vector<WallLine>& lines) {
  for (WallLine& line : lines) {
    for (const PlanAxis& axis : axes) {
      const double off = turn_from(axis.yaw_rad, line);
      const double sigma = hypotenuse(hypotenuse(line.sigma_yaw_rad, axis.sigma_rad), 0.5e-3);
      if (std::abs(off) > kPlan.axis_sigmas * sigma ||
          std::abs(off) > radians(kPlan.axis_most_deg)) {
        continue;
      }
      const double c = std::cos(-off);
      const double s = std::sin(-off);
      line.along = Eigen::Vector2d(c * line.along.x() - s * line.along.y(),
                                   s * line.along.x() + c * line.along.y());
      line.sigma_yaw_rad = std::min(line.sigma_yaw_rad, axis.sigma_rad);
      line.squared = true;
      break;
    }
  }
}

}  // namespace loopstone
