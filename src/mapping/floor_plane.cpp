#include "loopstone/mapping/floor_plane.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/median.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr int kEvery = 4;  ///< pixels looked at, in both directions
constexpr double kHeightGate_m = 0.08;
constexpr double kTiltGate_rad = radians(4.0);
constexpr std::size_t kFewestPoints = 400;
constexpr double kGate = 3.0;  ///< in standard deviations

/// Normal equations of slope . (x, y, 1) = inverse depth.
struct PlaneSums {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::size_t points = 0;

  void add(const Eigen::Vector3d& ray, double per_m) {
    normal.noalias() += ray * ray.transpose();
    right += per_m * ray;
    ++points;
  }
  /// Nothing when the points do not span a plane.
  [[nodiscard]] std::optional<FloorPlane> solve() const {
    if (points < kFewestPoints) return {};
    const Eigen::LDLT<Eigen::Matrix3d> factor(normal);
    const Eigen::Vector3d pivots = factor.vectorD();
    if (pivots.minCoeff() < 1e-6 * static_cast<double>(points)) return {};
    return FloorPlane{factor.solve(right)};
  }
};

/// What was measured along a ray less what the plane says.
template <typename Sample>
double residual(const FloorPlane& plane, const Sample& s) {
  return s.per_m - (plane.slope.x() * s.x + plane.slope.y() * s.y + plane.slope.z());
}

/// Of the measurements that lie within the gate about a plane.
template <typename Sample>
PlaneSums sums_about(const FloorPlane& plane, double gate, std::span<const Sample> samples) {
  PlaneSums sums;
  for (const Sample& s : samples) {
    if (std::abs(residual(plane, s)) > gate) continue;
    sums.add({s.x, s.y, 1.0}, s.per_m);
  }
  return sums;
}

/// A plane through what lies near it.
struct PlaneFit {
  FloorPlane plane{};
  double noise_per_m = 0.0;
  std::size_t points = 0;

  [[nodiscard]] double gate() const { return kGate * noise_per_m; }
};

/// The spread of the residuals tells the noise, the fit within the gate the plane; both settle in a
/// few rounds. Nothing where there is too little floor.
template <typename Sample>
std::optional<PlaneFit> fit_plane(std::span<const Sample> samples, const FloorPlane& start) {
  constexpr int kRounds = 6;
  PlaneFit fit{.plane = start};
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> spread;
    spread.reserve(samples.size());
    for (const Sample& s : samples) spread.push_back(residual(fit.plane, s));
    if (spread.size() < kFewestPoints) return {};
    const double middle = round == 0 ? median_of(spread) : 0.0;
    for (double& value : spread) value = std::abs(value - middle);
    fit.noise_per_m = std::max(kSigmaPerMedian * median_of(spread), 1e-6);
    // At first the plane may be off as a whole; a shift of it does no harm to the gate.
    const FloorPlane about{fit.plane.slope + Eigen::Vector3d(0.0, 0.0, middle)};
    const PlaneSums sums = sums_about(about, fit.gate(), samples);
    const auto solved = sums.solve();
    if (!solved) return {};
    fit.plane = *solved;
    fit.points = sums.points;
  }
  return fit;
}

}  // namespace

FloorPlane floor_plane_of(const Pose3& robot_T_camera) {
  // Points X of the floor obey up . X = -height in the optical frame; X = depth * ray.
  const Eigen::Matrix3d robot_R_optical =
      robot_T_camera.rotation.toRotationMatrix() * body_R_optical();
  const Eigen::Vector3d up = robot_R_optical.transpose() * Eigen::Vector3d::UnitZ();
  return {-up / robot_T_camera.translation.z()};
}

Pose3 mount_seeing(const FloorPlane& plane, const Pose3& robot_T_camera) {
  // In the camera's body-like frame up is (-sin pitch, cos pitch sin roll, cos pitch cos roll).
  const Eigen::Vector3d up = body_R_optical() * (-plane.slope * plane.height_m());
  const double pitch = -std::asin(std::clamp(up.x(), -1.0, 1.0));
  const double roll = std::atan2(up.y(), up.z());
  Eigen::Vector3d translation = robot_T_camera.translation;
  translation.z() = plane.height_m();
  return Pose3::from_roll_pitch_yaw(translation, roll, pitch,
                                    to_roll_pitch_yaw(robot_T_camera).z());
}

FloorPlaneEstimator::FloorPlaneEstimator(const CameraModel& camera)
    : camera_(camera), given_(floor_plane_of(camera.robot_T_camera)) {
  for (int row = 0; row < camera.depth.height_px; row += kEvery) {
    for (int column = 0; column < camera.depth.width_px; column += kEvery) {
      const Eigen::Vector3d ray = ray_through(camera.depth, Eigen::Vector2d(column, row));
      rays_.emplace_back(ray.head<2>().cast<float>());
    }
  }
}

void FloorPlaneEstimator::add(const InverseDepthImage& depth) {
  frame_starts_.push_back(samples_.size());
  const double height_m = given_.height_m();
  std::size_t i = 0;
  for (int row = 0; row < depth.height; row += kEvery) {
    for (int column = 0; column < depth.width; column += kEvery, ++i) {
      const double per_m = depth.at(column, row);
      if (per_m <= 0.0) continue;
      const Eigen::Vector2d ray = rays_[i].cast<double>();
      const double expected =
          given_.slope.x() * ray.x() + given_.slope.y() * ray.y() + given_.slope.z();
      // On one ray the height above the floor is linear in depth.
      const double above_m = height_m * (1.0 - expected / per_m);
      const double distance_m = std::sqrt(1.0 + ray.squaredNorm()) / per_m;
      if (std::abs(above_m) > kHeightGate_m + kTiltGate_rad * distance_m) continue;
      samples_.push_back({rays_[i].x(), rays_[i].y(), static_cast<float>(per_m)});
    }
  }
}

FloorEstimate FloorPlaneEstimator::estimate() const {
  FloorEstimate result;
  result.robot_T_camera = camera_.robot_T_camera;
  result.plane = given_;
  const std::span<const Sample> samples(samples_);
  const auto fit = fit_plane(samples, given_);
  if (!fit) return result;

  std::vector<double> pitches;
  for (std::size_t frame = 0; frame < frame_starts_.size(); ++frame) {
    const std::size_t begin = frame_starts_[frame];
    const std::size_t end =
        frame + 1 < frame_starts_.size() ? frame_starts_[frame + 1] : samples_.size();
    const auto solved =
        sums_about(fit->plane, fit->gate(), samples.subspan(begin, end - begin)).solve();
    if (!solved) continue;
    ++result.frames;
    pitches.push_back(to_roll_pitch_yaw(mount_seeing(*solved, camera_.robot_T_camera)).y());
  }
  if (result.frames == 0) return result;

  result.status = FloorStatus::kEstimated;
  result.plane = fit->plane;
  result.robot_T_camera = mount_seeing(fit->plane, camera_.robot_T_camera);
  const Eigen::Vector3d given = to_roll_pitch_yaw(camera_.robot_T_camera);
  const Eigen::Vector3d found = to_roll_pitch_yaw(result.robot_T_camera);
  result.roll_error_rad = found.x() - given.x();
  result.pitch_error_rad = found.y() - given.y();
  result.height_error_m =
      result.robot_T_camera.translation.z() - camera_.robot_T_camera.translation.z();
  result.noise_per_m = fit->noise_per_m;
  result.points = static_cast<std::int64_t>(fit->points);
  for (double& pitch : pitches) pitch = std::abs(pitch - found.y());
  result.pitch_scatter_rad = kSigmaPerMedian * median_of(pitches);
  return result;
}

}  // namespace loopstone
