#include "slam/sweep_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/calibration.hpp"
#include "slam/robust_fit.hpp"

namespace loopstone {

namespace {

/// Nothing is known of the sweep before the scans are asked.
constexpr double kSweepPriorS = 0.5;

/// Two of the scans.
struct Pair {
  std::size_t from = 0;
  std::size_t to = 0;
  double differ_rad_s = 0.0;
};

/// A surface and how it moves with the sweep: derivative of its position by the sweep's duration.
struct SweptPoint {
  Eigen::Vector2d position;
  Eigen::Vector2d normal;
  Eigen::Vector2d by_sweep;
};

/// From the middle of the sweep, which the front end's pose is nearest to, to the first beam.
Pose2 at_first_beam(const MovingScan& scan, double sweep_s) {
  return scan.local_T_robot * exp(Tangent2(scan.velocity * (-0.5 * sweep_s)));
}

/// The surfaces of a scan when its sweep takes so long, in the robot's frame at the first beam.
std::vector<SweptPoint> swept_points(const MovingScan& moving, double sweep_s, BeamTable& beams) {
  LaserScan scan = *moving.scan;
  const auto count = static_cast<double>(scan.ranges_m.size());
  scan.time_increment_s = sweep_s / count;
  const SurfaceOptions options{.range_max_m = kSweep.range_max_m, .points_max = kSweep.points};
  const double middle_rad = scan.angle_min_rad + 0.5 * count * scan.angle_increment_rad;
  const Pose2 lidar_T_robot = moving.robot_T_lidar.inverse();
  std::vector<SweptPoint> points;
  for (const SurfacePoint& seen :
       surface_points(scan, moving.robot_T_lidar, moving.velocity, options, beams)) {
    if (seen.weight < 1.0F) continue;
    const Eigen::Vector2d position = seen.position.cast<double>();
    const Eigen::Vector2d in_lidar = lidar_T_robot * position;
    const double bearing = std::atan2(in_lidar.y(), in_lidar.x());
    const auto share_at = [&](double angle) {
      return 0.5 + wrap_angle(angle - middle_rad) / (count * scan.angle_increment_rad);
    };
    // The laser has turned meanwhile, so that beam looked less far round.
    const double share = share_at(bearing - moving.velocity.z() * sweep_s * share_at(bearing));
    const Eigen::Vector2d speed =
        moving.velocity.head<2>() +
        moving.velocity.z() * Eigen::Vector2d(-position.y(), position.x());
    points.push_back({position, seen.normal.cast<double>(), share * speed});
  }
  return points;
}

/// Normal equations of (x, y, yaw, sweep) of a pair.
struct Normals {
  Eigen::Matrix4d h = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  int points = 0;
};

struct Residual {
  double r = 0.0;
  Eigen::Vector4d jacobian = Eigen::Vector4d::Zero();
};

std::vector<Residual> residuals_of(const std::vector<SweptPoint>& from,
                                   const std::vector<SweptPoint>& to, const Pose2& to_T_from,
                                   double reach_m) {
  std::vector<Residual> residuals;
  const Eigen::Matrix2d rotation = to_T_from.rotation();
  for (const SweptPoint& point : from) {
    const Eigen::Vector2d turned = rotation * point.position;
    const Eigen::Vector2d at = turned + to_T_from.translation();
    const Eigen::Vector2d normal = rotation * point.normal;
    const SweptPoint* nearest = nullptr;
    double least = reach_m * reach_m;
    for (const SweptPoint& other : to) {
      const double squared = (other.position - at).squaredNorm();
      if (squared >= least || other.normal.dot(normal) < kSweep.same_normal) continue;
      least = squared;
      nearest = &other;
    }
    if (nearest == nullptr) continue;
    const Eigen::Vector2d& n = nearest->normal;
    Residual residual;
    residual.r = n.dot(at - nearest->position);
    residual.jacobian << n.x(), n.y(), n.dot(Eigen::Vector2d(-turned.y(), turned.x())),
        n.dot(rotation * point.by_sweep - nearest->by_sweep);
    residuals.push_back(residual);
  }
  return residuals;
}

Normals normals_of(const std::vector<Residual>& residuals) {
  std::vector<double> sizes;
  sizes.reserve(residuals.size());
  for (const Residual& residual : residuals) sizes.push_back(std::abs(residual.r));
  const double sigma = std::max(kSigmaPerMedian * median_of(sizes), 1e-3);
  Normals normals;
  normals.points = static_cast<int>(residuals.size());
  for (const Residual& residual : residuals) {
    const double far = residual.r / (kCalibration.outlier_sigmas * sigma);
    const double root = 1.0 / (1.0 + far * far);
    const double weight = root * root / (sigma * sigma);
    normals.h += weight * residual.jacobian * residual.jacobian.transpose();
    normals.b -= weight * residual.r * residual.jacobian;
  }
  return normals;
}

/// What a pair says of the sweep when its motion is free: information, and information times the
/// correction.
struct Saying {
  double information = 0.0;
  double score = 0.0;
};

class PairAlignment {
 public:
  PairAlignment(const MovingScan& from, const MovingScan& to, double sweep_s, BeamTable& beams)
      : from_(swept_points(from, sweep_s, beams)),
        to_(swept_points(to, sweep_s, beams)),
        guess_(at_first_beam(to, sweep_s).inverse() * at_first_beam(from, sweep_s)) {}

  [[nodiscard]] std::optional<Saying> saying() const {
    const Eigen::Vector3d prior = Eigen::Vector3d(kSweep.prior_m, kSweep.prior_m, kSweep.prior_rad)
                                      .array()
                                      .square()
                                      .inverse();
    Pose2 pose = guess_;
    Normals normals;
    for (int step = 0; step <= kSweep.steps; ++step) {
      const double reach_m = step < kSweep.steps / 2 ? kSweep.pair_m : kSweep.last_pair_m;
      normals = normals_of(residuals_of(from_, to_, pose, reach_m));
      if (normals.points < kSweep.fewest_points) return {};
      const Eigen::Vector3d off(pose.x - guess_.x, pose.y - guess_.y,
                                wrap_angle(pose.yaw - guess_.yaw));
      normals.h.topLeftCorner<3, 3>().diagonal() += prior;
      normals.b.head<3>() -= prior.cwiseProduct(off);
      if (step == kSweep.steps) break;
      const Eigen::Vector3d move =
          solve_symmetric<double, 3>(normals.h.topLeftCorner<3, 3>(), normals.b.head<3>());
      pose = {pose.x + move.x(), pose.y + move.y(), wrap_angle(pose.yaw + move.z())};
    }
    const Eigen::Vector3d cross = normals.h.topRightCorner<3, 1>();
    const Eigen::Vector3d solved =
        solve_symmetric<double, 3>(normals.h.topLeftCorner<3, 3>(), cross);
    const Saying saying{normals.h(3, 3) - cross.dot(solved),
                        normals.b[3] - solved.dot(normals.b.head<3>())};
    if (!(saying.information > 0.0) || !std::isfinite(saying.score)) return {};
    return saying;
  }

 private:
  std::vector<SweptPoint> from_;
  std::vector<SweptPoint> to_;
  Pose2 guess_;
};

/// Of each scan the partner before it that turned most differently.
std::vector<Pair> possible_pairs(std::span<const MovingScan> scans) {
  std::vector<Pair> pairs;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    Pair best{i, i, kSweep.differ_rad_s};
    const std::size_t first = i - std::min(i, static_cast<std::size_t>(kSweep.partners));
    for (std::size_t j = first; j < i; ++j) {
      const Pose2 motion = scans[j].local_T_robot.inverse() * scans[i].local_T_robot;
      if (hypotenuse(motion.x, motion.y) > kSweep.partner_m ||
          std::abs(motion.yaw) > kSweep.partner_rad)
        continue;
      const double differ = std::abs(scans[i].velocity.z() - scans[j].velocity.z());
      if (differ > best.differ_rad_s) best = {i, j, differ};
    }
    if (best.from != best.to) pairs.push_back(best);
  }
  return pairs;
}

/// The best of each stretch, in order.
std::vector<Pair> chosen_pairs(std::span<const MovingScan> scans) {
  const std::vector<Pair> possible = possible_pairs(scans);
  std::vector<Pair> chosen;
  const auto stretches = static_cast<std::size_t>(kSweep.stretches);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t first = k * possible.size() / stretches;
    const std::size_t end = (k + 1) * possible.size() / stretches;
    std::vector<Pair> of_stretch(possible.begin() + static_cast<std::ptrdiff_t>(first),
                                 possible.begin() + static_cast<std::ptrdiff_t>(end));
    std::ranges::stable_sort(of_stretch, std::greater<>{}, &Pair::differ_rad_s);
    of_stretch.resize(
        std::min(of_stretch.size(), static_cast<std::size_t>(kSweep.pairs_of_stretch)));
    std::ranges::sort(of_stretch, std::less<>{}, &Pair::from);
    chosen.insert(chosen.end(), of_stretch.begin(), of_stretch.end());
  }
  return chosen;
}

/// All pairs as one problem in the correction of the sweep: a pair is an observation of weight 1.
LinearProblem problem_at(std::span<const MovingScan> scans, const std::vector<Pair>& pairs,
                         double sweep_s, BeamTable& beams) {
  std::vector<Saying> sayings;
  for (const Pair& pair : pairs) {
    const PairAlignment alignment(scans[pair.from], scans[pair.to], sweep_s, beams);
    if (const auto saying = alignment.saying()) sayings.push_back(*saying);
  }
  const auto count = static_cast<Eigen::Index>(sayings.size());
  LinearProblem problem{Eigen::MatrixXd(count, 1), Eigen::VectorXd(count), 1,
                        Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, kSweepPriorS)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Saying& saying = sayings[static_cast<std::size_t>(i)];
    problem.a(i, 0) = std::sqrt(saying.information);
    problem.y[i] = saying.score / std::sqrt(saying.information);
  }
  return problem;
}

bool halves_agree(const LinearProblem& problem, double so_far_s, double whole_s) {
  const Eigen::Index middle = problem.observations() / 2;
  for (const auto& half :
       {problem.part(0, middle), problem.part(middle, problem.observations() - middle)}) {
    const double part_s = so_far_s + robust_fit(half).x[0];
    if (!(part_s * whole_s > kSweep.half_agrees * whole_s * whole_s)) return false;
  }
  return true;
}

/// Usual time from scan to scan.
double period_s(std::span<const MovingScan> scans) {
  std::vector<double> seconds;
  for (std::size_t i = 1; i < scans.size(); ++i)
    seconds.push_back((scans[i].scan->stamp - scans[i - 1].scan->stamp).seconds());
  return median_of(seconds);
}

/// Nothing where both sides tell different ones: late stamps, a gap, a pose that was corrected.
std::optional<Tangent2> velocity_about(const std::deque<TrackedPose>& track, std::size_t index) {
  std::size_t before = index;
  std::size_t after = index;
  const auto since = [&](std::size_t from, std::size_t to) {
    return (track[to].stamp - track[from].stamp).seconds();
  };
  while (before > 0 && since(before, index) < kSweep.velocity_s) --before;
  while (after + 1 < track.size() && since(index, after) < kSweep.velocity_s) ++after;
  const auto velocity = [&](std::size_t from, std::size_t to) -> Tangent2 {
    return log(track[from].local_T_robot.inverse() * track[to].local_T_robot) / since(from, to);
  };
  if (!(since(before, after) > 0.0) || since(before, after) > kSweep.longest_velocity_s) return {};
  const Tangent2 whole = velocity(before, after);
  if (before == index || after == index) return whole;  // an end of the track
  const Tangent2 change = velocity(index, after) - velocity(before, index);
  const auto is_steady = [](double change_size, double size, double rest) {
    return change_size <= std::max(rest, kSweep.steady_share * size);
  };
  if (!is_steady(std::abs(change.z()), std::abs(whole.z()), kSweep.steady_rad_s) ||
      !is_steady(change.head<2>().norm(), whole.head<2>().norm(), kSweep.steady_m_s))
    return {};
  return whole;
}

}  // namespace

bool SweepFit::is_off() const {
  return pairs > 0 && halves_agree &&
         std::abs(sweep_s) > std::max(kSweep.sigmas * sigma_s, kSweep.least_s);
}

std::vector<MovingScan> untold_scans(std::span<const SubmapRecord> submaps,
                                     const std::deque<TrackedPose>& track, int lidar) {
  std::vector<MovingScan> scans;
  for (const SubmapRecord& submap : submaps) {
    submap.scans.for_each([&](const MappedScan& mapped) {
      if (mapped.scan.lidar != lidar || mapped.scan.time_increment_s != 0.0) return;
      if (mapped.scan.ranges_m.empty() || mapped.scan.angle_increment_rad == 0.0) return;
      if (mapped.index >= track.size()) return;
      const auto velocity = velocity_about(track, mapped.index);
      if (!velocity) return;
      scans.push_back({&mapped.scan, mapped.robot_T_lidar, mapped.local_T_robot, *velocity});
    });
  }
  return scans;
}

std::optional<SweepFit> fit_sweep(std::span<const MovingScan> scans) {
  const std::vector<Pair> pairs = chosen_pairs(scans);
  const auto enough = static_cast<std::size_t>(kSweep.fewest_pairs);
  if (pairs.size() < enough) return {};
  const double longest_s = kSweep.longest_periods * period_s(scans);
  BeamTable beams;
  SweepFit fit;
  for (int round = 0; round < kSweep.rounds; ++round) {
    const LinearProblem problem = problem_at(scans, pairs, fit.sweep_s, beams);
    if (static_cast<std::size_t>(problem.observations()) < enough) return {};
    const LinearFit found = robust_fit(problem);
    const double correction_s = found.x[0];
    const double sweep_s = fit.sweep_s + correction_s;
    const double scatter = scatter_of_blocks(problem, kCalibration.blocks)[0];
    fit.sigma_s =
        hypotenuse(scatter * std::sqrt(found.covariance(0, 0)), kSweep.share_in_doubt * sweep_s);
    fit.pairs = static_cast<std::size_t>(problem.observations());
    fit.halves_agree = halves_agree(problem, fit.sweep_s, sweep_s);
    fit.sweep_s = std::clamp(sweep_s, -longest_s, longest_s);
    const bool may_be =
        std::abs(sweep_s) > std::max(kCalibration.sigmas * fit.sigma_s, 0.5 * kSweep.least_s);
    if (!may_be || std::abs(correction_s) < kSweep.settled_s) break;
  }
  return fit;
}

}  // namespace loopstone
