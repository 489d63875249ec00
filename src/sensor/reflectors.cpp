#include "loopstone/sensor/reflectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {
namespace {

/// Fewer beams of a range tell nothing of what is usual there.
constexpr std::size_t kEnoughBeams = 20;
/// Ranges of neighbouring beams on one reflector differ by less, and what hides one is nearer by
/// more.
constexpr double kStepM = 0.1;

/// Half an octave of ranges.
int band_of(float range_m) { return static_cast<int>(std::floor(2.0F * std::log2(range_m))); }

float median_of(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

bool is_return(const LaserScan& scan, std::size_t beam) {
  return std::isfinite(scan.ranges_m[beam]) && scan.ranges_m[beam] > 0.0F &&
         std::isfinite(scan.intensities[beam]);
}

/// What is usual at each range: the medians of bands that have enough beams.
class UsualIntensity {
 public:
  explicit UsualIntensity(const LaserScan& scan) {
    std::map<int, std::vector<float>> bands;
    std::vector<float> all;
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      if (!is_return(scan, beam)) continue;
      bands[band_of(scan.ranges_m[beam])].push_back(scan.intensities[beam]);
      all.push_back(scan.intensities[beam]);
    }
    for (const auto& [band, values] : bands) {
      if (values.size() >= kEnoughBeams) medians_[band] = median_of(values);
    }
    if (medians_.empty() && !all.empty()) {
      for (const auto& [band, values] : bands) medians_[band] = median_of(all);
    }
  }

  /// Where a range itself has too few beams, the most that its neighbours suggest: nearer things
  /// are no darker, and of those farther away light is lost with the range.
  [[nodiscard]] double at(float range_m) const {
    const int band = band_of(range_m);
    const auto farther = medians_.lower_bound(band);
    if (farther != medians_.end() && farther->first == band)
      return static_cast<double>(farther->second);
    double usual = 0.0;
    if (farther != medians_.end()) {
      const double ratio = std::sqrt(std::ldexp(1.0, farther->first - band));
      usual = ratio * static_cast<double>(farther->second);
    }
    if (farther != medians_.begin()) {
      usual = std::max(usual, static_cast<double>(std::prev(farther)->second));
    }
    return usual;
  }

 private:
  std::map<int, float> medians_{};  ///< by band
};

std::vector<bool> bright_beams(const LaserScan& scan, const ReflectorOptions& options) {
  const UsualIntensity usual(scan);
  std::vector<bool> bright(scan.ranges_m.size(), false);
  for (std::size_t beam = 0; beam < bright.size(); ++beam) {
    if (!is_return(scan, beam) || scan.intensities[beam] <= 0.0F) continue;
    const auto intensity = static_cast<double>(scan.intensities[beam]);
    bright[beam] = intensity >= options.brightness * usual.at(scan.ranges_m[beam]) &&
                   intensity >= options.intensity_min;
  }
  return bright;
}

/// The bright beams of one thing, in their order.
using Cluster = std::vector<std::size_t>;

std::vector<Cluster> clusters_of(const LaserScan& scan, const std::vector<bool>& bright) {
  std::vector<Cluster> clusters;
  for (std::size_t beam = 0; beam < bright.size(); ++beam) {
    if (!bright[beam]) continue;
    const auto goes_on = [&] {
      if (clusters.empty()) return false;
      const std::size_t last = clusters.back().back();
      const bool next = beam == last + 1 || (beam == last + 2 && !is_return(scan, last + 1));
      return next && std::abs(scan.ranges_m[beam] - scan.ranges_m[last]) < kStepM;
    };
    if (goes_on()) {
      clusters.back().push_back(beam);
    } else {
      clusters.push_back({beam});
    }
  }
  return clusters;
}

/// Its edge is that of something nearer, or of the scan.
bool is_cut(const LaserScan& scan, const Cluster& cluster) {
  const std::size_t first = cluster.front();
  const std::size_t last = cluster.back();
  if (first == 0 || last + 1 == scan.ranges_m.size()) return true;
  const auto hides = [&](std::size_t beside, std::size_t edge) {
    return static_cast<double>(scan.ranges_m[beside]) <
           static_cast<double>(scan.ranges_m[edge]) - kStepM;
  };
  return hides(first - 1, first) || hides(last + 1, last);
}

LandmarkObservation observation_of(const LaserScan& scan, const Cluster& cluster,
                                   const Pose2& robot_T_lidar, const Tangent2& velocity,
                                   const ReflectorOptions& options) {
  const auto count = static_cast<double>(cluster.size());
  double beam = 0.0;
  for (const std::size_t index : cluster) beam += static_cast<double>(index) / count;
  const double bearing = scan.angle_min_rad + beam * scan.angle_increment_rad;
  double range = 0.0;
  std::vector<double> beside;
  std::vector<double> along;
  for (const std::size_t index : cluster) {
    const double off = scan.angle_rad(index) - bearing;
    const auto way = static_cast<double>(scan.ranges_m[index]);
    along.push_back(way * std::cos(off));
    range += along.back() / count;
    beside.push_back(way * std::sin(off));
  }
  const double beam_sigma = scan.angle_increment_rad / std::sqrt(12.0);
  const double bearing_sigma = hypotenuse(options.bearing_sigma_rad, beam_sigma);
  // Where the sensor was when it saw this, from where the robot was at the scan's stamp.
  const Pose2 robot_T_then = exp(Tangent2(velocity * (beam * scan.time_increment_s)));
  LandmarkObservation seen =
      observed(range, bearing, options.range_sigma_m, bearing_sigma, robot_T_then * robot_T_lidar);
  seen.beams_beside_m = std::move(beside);
  for (double& way : along) way -= range;
  seen.beams_beyond_m = std::move(along);
  const Eigen::Vector2d passing(velocity.x() - velocity.z() * seen.point.y(),
                                velocity.y() + velocity.z() * seen.point.x());
  seen.covariance += options.stamp_sigma_s * options.stamp_sigma_s * passing * passing.transpose();
  return seen;
}

}  // namespace

std::vector<LandmarkObservation> find_reflectors(const LaserScan& scan, const Pose2& robot_T_lidar,
                                                 const Tangent2& velocity,
                                                 const ReflectorOptions& options) {
  std::vector<LandmarkObservation> found;
  if (scan.intensities.size() != scan.ranges_m.size()) return found;
  for (const Cluster& cluster : clusters_of(scan, bright_beams(scan, options))) {
    const auto range = static_cast<double>(scan.ranges_m[cluster.front()]);
    const double width = range * std::abs(scan.angle_increment_rad) *
                         static_cast<double>(cluster.back() - cluster.front() + 1);
    const bool is_reflector = static_cast<int>(cluster.size()) >= options.beams_min &&
                              width <= options.width_max_m && range <= options.range_max_m;
    if (!is_reflector || is_cut(scan, cluster)) continue;
    found.push_back(observation_of(scan, cluster, robot_T_lidar, velocity, options));
  }
  return found;
}

}  // namespace loopstone
