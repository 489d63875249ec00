#include "loopstone/sensor/scan_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace loopstone {

namespace {

/// Neighbouring returns farther apart than kGap + kSlant * spacing of the beams belong to different
/// surfaces; a wall seen at 80 deg from its normal spreads the beams by 1 / cos(80 deg) = 5.8.
constexpr double kGapM = 0.1;
constexpr double kSlant = 6.0;
/// A neighbourhood is a line when its thickness (standard deviation) stays below this share of its
/// length.
constexpr double kLineThickness = 0.35;
constexpr float kGuessedNormalWeight = 0.25F;

struct Return {
  Eigen::Vector2d point;      // robot frame at the scan's stamp
  Eigen::Vector2d direction;  // of the beam, robot frame
  double range = 0.0;
  std::size_t beam = 0;
};

/// Where the lidar was at each beam, in the frame of the robot at the scan's stamp. Goes from beam
/// to beam by one small motion, so that no beam costs a sine.
class MovingLidar {
 public:
  MovingLidar(const LaserScan& scan, const Pose2& robot_T_lidar, const Tangent2& velocity)
      : moves_(scan.time_increment_s != 0.0 && !velocity.isZero(0.0)),
        rotation_(robot_T_lidar.rotation()),
        translation_(robot_T_lidar.translation()) {
    // robot_T_beam(i) = exp(i step) * robot_T_lidar = robot_T_lidar * exp(i step seen from the
    // lidar)
    const Pose2 step =
        robot_T_lidar.inverse() * exp(Tangent2(velocity * scan.time_increment_s)) * robot_T_lidar;
    step_rotation_ = step.rotation();
    step_translation_ = step.translation();
  }

  [[nodiscard]] const Eigen::Matrix2d& rotation() const { return rotation_; }
  [[nodiscard]] const Eigen::Vector2d& translation() const { return translation_; }
  void next_beam() {
    if (!moves_) return;
    translation_ += rotation_ * step_translation_;
    rotation_ = (rotation_ * step_rotation_).eval();
  }

 private:
  bool moves_;
  Eigen::Matrix2d rotation_;
  Eigen::Vector2d translation_;
  Eigen::Matrix2d step_rotation_;
  Eigen::Vector2d step_translation_;
};

std::vector<Return> returns_of(const LaserScan& scan, const Pose2& robot_T_lidar,
                               const Tangent2& velocity, double range_max_m,
                               const std::vector<Eigen::Vector2d>& directions) {
  MovingLidar lidar(scan, robot_T_lidar, velocity);
  const double range_max = std::min(range_max_m, scan.range_max_m);
  std::vector<Return> returns;
  returns.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i, lidar.next_beam()) {
    const double range = scan.ranges_m[i];
    if (!(range >= scan.range_min_m && range <= range_max && range > 0.0)) continue;
    const Eigen::Vector2d direction = lidar.rotation() * directions[i];
    returns.push_back({lidar.translation() + range * direction, direction, range, i});
  }
  return returns;
}

/// Sums over a prefix of the returns, so that the moments of any run of neighbours are one
/// subtraction.
struct Moments {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
};

std::vector<Moments> prefix_moments(const std::vector<Return>& returns) {
  std::vector<Moments> prefix;
  prefix.reserve(returns.size() + 1);
  Moments total;
  prefix.push_back(total);
  for (const Return& seen : returns) {
    const Eigen::Vector2d& p = seen.point;
    total.sum += p;
    total.xx += p.x() * p.x();
    total.xy += p.x() * p.y();
    total.yy += p.y() * p.y();
    prefix.push_back(total);
  }
  return prefix;
}

/// Returns [first, last) of an unbroken surface.
struct Run {
  std::size_t first;
  std::size_t last;
};

/// One after the other, all returns.
std::vector<Run> unbroken_runs(const std::vector<Return>& returns, double beam_spacing_rad) {
  std::vector<Run> runs;
  std::size_t start = 0;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    if (i + 1 < returns.size()) {
      const double gap =
          kGapM + kSlant * beam_spacing_rad * std::min(returns[i].range, returns[i + 1].range);
      if ((returns[i + 1].point - returns[i].point).squaredNorm() <= gap * gap) continue;
    }
    runs.push_back({start, i + 1});
    start = i + 1;
  }
  return runs;
}

/// Whether the beams on both sides of the run [first, last) see farther: then it is a small thing
/// that stands free, not a piece of a wall seen at a grazing angle.
bool stands_free(const std::vector<Return>& returns, std::size_t first, std::size_t last) {
  const bool before = first == 0 || returns[first - 1].beam + 1 < returns[first].beam ||
                      returns[first - 1].range > returns[first].range;
  const bool after = last == returns.size() || returns[last].beam > returns[last - 1].beam + 1 ||
                     returns[last].range > returns[last - 1].range;
  return before && after;
}

/// Fits a line to the returns [first, last) and projects return i on it. Nothing when no line fits
/// and none can be guessed.
std::optional<SurfacePoint> fit_line(const std::vector<Return>& returns,
                                     const std::vector<Moments>& prefix, const Run& run,
                                     std::size_t i, std::size_t first, std::size_t last) {
  const auto guess_along_beam = [&]() -> std::optional<SurfacePoint> {
    if (!stands_free(returns, run.first, run.last)) return {};
    return SurfacePoint{returns[i].point.cast<float>(), (-returns[i].direction).cast<float>(),
                        kGuessedNormalWeight};
  };
  if (last - first < 3) return guess_along_beam();
  const Moments& low = prefix[first];
  const Moments& high = prefix[last];
  const auto n = static_cast<double>(last - first);
  const Eigen::Vector2d mean = (high.sum - low.sum) / n;
  const double xx = (high.xx - low.xx) / n - mean.x() * mean.x();
  const double xy = (high.xy - low.xy) / n - mean.x() * mean.y();
  const double yy = (high.yy - low.yy) / n - mean.y() * mean.y();
  const double middle = 0.5 * (xx + yy);
  const double difference = 0.5 * (xx - yy);
  const double spread = std::sqrt(difference * difference + xy * xy);
  const double thin = std::max(0.0, middle - spread);
  const double lengthy = middle + spread;
  if (!(lengthy > 0.0) || thin > kLineThickness * kLineThickness * lengthy) {
    return guess_along_beam();
  }
  // The eigenvector of the smaller eigenvalue, from the row of the matrix that cancels least.
  Eigen::Vector2d normal = difference >= 0.0 ? Eigen::Vector2d(-xy, difference + spread)
                                             : Eigen::Vector2d(spread - difference, -xy);
  normal /= std::sqrt(normal.squaredNorm());
  if (normal.dot(returns[i].direction) > 0.0) normal = -normal;
  const Eigen::Vector2d on_line = returns[i].point - normal.dot(returns[i].point - mean) * normal;
  return SurfacePoint{on_line.cast<float>(), normal.cast<float>(), 1.0F};
}

/// Returns no nearer than this to the one kept before; one more than `most` when there are more.
void keep_evenly_spaced(const std::vector<Return>& returns, double spacing_m, std::size_t most,
                        std::vector<std::size_t>& kept) {
  kept.clear();
  for (std::size_t i = 0; i < returns.size() && kept.size() <= most; ++i) {
    if (!kept.empty() &&
        (returns[i].point - returns[kept.back()].point).squaredNorm() < spacing_m * spacing_m) {
      continue;
    }
    kept.push_back(i);
  }
}

}  // namespace

const std::vector<Eigen::Vector2d>& BeamTable::directions(const LaserScan& scan) {
  if (scan.ranges_m.size() != directions_.size() || scan.angle_min_rad != angle_min_rad_ ||
      scan.angle_increment_rad != angle_increment_rad_) {
    angle_min_rad_ = scan.angle_min_rad;
    angle_increment_rad_ = scan.angle_increment_rad;
    directions_.resize(scan.ranges_m.size());
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const double angle = scan.angle_rad(i);
      directions_[i] = {std::cos(angle), std::sin(angle)};
    }
  }
  return directions_;
}

std::vector<Eigen::Vector2d> scan_points(const LaserScan& scan, const Pose2& robot_T_lidar,
                                         const Tangent2& velocity) {
  BeamTable beams;
  const auto returns =
      returns_of(scan, robot_T_lidar, velocity, scan.range_max_m, beams.directions(scan));
  std::vector<Eigen::Vector2d> points;
  points.reserve(returns.size());
  for (const auto& seen : returns) points.push_back(seen.point);
  return points;
}

std::vector<SurfacePoint> surface_points(const LaserScan& scan, const Pose2& robot_T_lidar,
                                         const Tangent2& velocity, const SurfaceOptions& options,
                                         BeamTable& beams) {
  const auto returns =
      returns_of(scan, robot_T_lidar, velocity, options.range_max_m, beams.directions(scan));
  const double beam_spacing = std::abs(scan.angle_increment_rad);
  const auto runs = unbroken_runs(returns, beam_spacing);
  const auto prefix = prefix_moments(returns);

  const auto most = static_cast<std::size_t>(std::max(options.points_max, 1));
  double spacing = std::max(options.spacing_m, 0.001);
  std::vector<std::size_t> kept;
  kept.reserve(std::min(most, returns.size()) + 1);
  keep_evenly_spaced(returns, spacing, most, kept);
  while (kept.size() > most) {
    spacing *= 1.3;
    keep_evenly_spaced(returns, spacing, most, kept);
  }

  std::vector<SurfacePoint> surfaces;
  surfaces.reserve(kept.size());
  auto run = runs.begin();
  for (const std::size_t i : kept) {
    while (i >= run->last) ++run;
    const double between = std::max(1e-4, beam_spacing * returns[i].range);
    const auto reach =
        static_cast<std::size_t>(std::clamp(std::ceil(options.support_m / between), 1.0, 64.0));
    const std::size_t first = i - std::min(reach, i - run->first);
    const std::size_t last = std::min(i + reach + 1, run->last);
    if (const auto surface = fit_line(returns, prefix, *run, i, first, last))
      surfaces.push_back(*surface);
  }
  return surfaces;
}

}  // namespace loopstone
