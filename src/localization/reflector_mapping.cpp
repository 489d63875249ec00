#include "loopstone/localization/reflector_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "loopstone/base/option_list.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/reflectors.hpp"

namespace loopstone {
namespace {

/// A beam that ends so much farther away passed the place.
constexpr double kBeyondM = 0.3;
/// Beams are no farther apart than half of the smallest reflector.
constexpr double kBeamsApartM = 0.04;

/// How far the pose of a node, as the map knows it, lets a point that is fixed to it stray.
Eigen::Matrix2d carried_to(const Eigen::Vector2d& point, const Pose2& pose,
                           const Eigen::Matrix3d& covariance) {
  const Eigen::Vector2d arm = point - pose.translation();
  Eigen::Matrix<double, 2, 3> swung = Eigen::Matrix<double, 2, 3>::Identity();
  swung.col(2) << -arm.y(), arm.x();
  return swung * covariance * swung.transpose();
}

}  // namespace

ReflectorMapper::ReflectorMapper(const LandmarkMappingOptions& options) : options_(options) {
  require_valid(options_);
}

GraphAddition ReflectorMapper::addition() {
  return [this](PoseGraph& graph, std::span<const KeyView> keys) { add_to(graph, keys); };
}

void ReflectorMapper::add_to(PoseGraph& graph, std::span<const KeyView> keys) {
  std::vector<std::vector<LandmarkObservation>> seen;
  for (const KeyView& key : keys) {
    if (!key.scan->intensities.empty()) ++with_intensities_;
    seen.push_back(
        find_reflectors(*key.scan, key.robot_T_lidar, key.velocity, options_.reflectors));
  }
  mapping_ = map_landmarks(graph, seen, options_,
                           [&](std::size_t node, const Eigen::Vector2d& point) {
                             return sees_through(keys[node], point);
                           });
  graph = std::move(mapping_.graph);
  mapping_.graph = {};
}

LandmarkMapping ReflectorMapper::settle(const MapResult& result) const {
  LandmarkMapping mapping = mapping_;
  const PoseGraph& graph = result.graph;
  for (std::size_t i = 0; i < mapping.landmarks.size(); ++i)
    mapping.landmarks[i].position = graph.landmarks[i];
  if (!result.covariances.available()) return mapping;
  // Of the poses that saw it the one that holds it best.
  for (FoundLandmark& landmark : mapping.landmarks)
    landmark.covariance = Eigen::Matrix2d::Constant(std::numeric_limits<double>::infinity());
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    FoundLandmark& landmark = mapping.landmarks[static_cast<std::size_t>(edge.landmark.index)];
    const Pose2& pose = graph.poses[static_cast<std::size_t>(edge.from.index)];
    const Eigen::Matrix2d covariance =
        carried_to(landmark.position, pose, result.covariances.of(edge.from));
    if (covariance.trace() < landmark.covariance.trace()) landmark.covariance = covariance;
  }
  return mapping;
}

std::optional<bool> sees_through(const KeyView& key, const Eigen::Vector2d& point) {
  const LaserScan& scan = *key.scan;
  const Eigen::Vector2d there = key.robot_T_lidar.inverse() * point;
  const double distance = there.norm();
  const double step = std::abs(scan.angle_increment_rad);
  if (step == 0.0 || distance * step > kBeamsApartM || distance < scan.range_min_m ||
      distance + kBeyondM > scan.range_max_m)
    return {};
  const double turn = wrap_angle(std::atan2(there.y(), there.x()) - scan.angle_min_rad);
  const double along = scan.angle_increment_rad > 0.0 ? turn : -turn;
  const double beam = std::round((along < 0.0 ? along + 2.0 * kPi : along) / step);
  const auto count = static_cast<double>(scan.ranges_m.size());
  if (beam < 1.0 || beam + 1.0 >= count) return {};
  double nearest = std::numeric_limits<double>::infinity();
  for (const int beside : {-1, 0, 1}) {
    const float range = scan.ranges_m[static_cast<std::size_t>(beam + beside)];
    if (std::isnan(range)) return {};
    nearest = std::min(nearest, static_cast<double>(range));
  }
  if (nearest < distance - kBeyondM) return {};
  return nearest > distance + kBeyondM;
}

}  // namespace loopstone
