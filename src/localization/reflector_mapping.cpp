#include "loopstone/localization/reflector_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "localization/landmark_group.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/sensor/reflectors.hpp"

namespace loopstone {
namespace {

/// A beam that ends so much farther away passed the place.
constexpr double kBeyondM = 0.3;
/// Beams are no farther apart than half of the smallest reflector.
constexpr double kBeamsApartM = 0.04;

/// How far a pose that is known so well lets a point stray that is fixed to it at `arm`.
Eigen::Matrix2d carried_to(const Eigen::Vector2d& arm, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix<double, 2, 3> swung = RigidMotion<2>::point_jacobian(arm);
  return swung * covariance * swung.transpose();
}

/// Against the first pose: by that of the poses that saw it which holds it best, and by all
/// sightings from there. Among the others: two ends of the path from which it was seen, that may
/// be off against one another, put it in two places, and it is in their midst.
void judge(FoundLandmark& landmark, std::span<const LandmarkEdge* const> sightings,
           std::span<const Pose2> poses, const PoseCovariances& covariances) {
  const auto pose = [&](NodeId node) { return poses[static_cast<std::size_t>(node.index)]; };
  const auto arm = [&](NodeId node) -> Eigen::Vector2d {
    return landmark.position - pose(node).translation();
  };
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d best = Eigen::Matrix2d::Constant(std::numeric_limits<double>::infinity());
  for (const LandmarkEdge* edge : sightings) {
    const Eigen::Matrix2d turn = pose(edge->from).rotation();
    information += turn * edge->information * turn.transpose();
    const Eigen::Matrix2d held = carried_to(arm(edge->from), covariances.of(edge->from));
    if (held.trace() < best.trace()) best = held;
  }
  const NodeId first = sightings.front()->from;
  const NodeId last = (*std::ranges::max_element(sightings, {}, [&](const LandmarkEdge* edge) {
                        return (pose(edge->from).translation() - pose(first).translation()).norm();
                      }))->from;
  const Eigen::Matrix2d own = information.inverse();
  landmark.covariance = best + own;
  const Eigen::Matrix2d first_R_map = pose(first).rotation().transpose();
  const Eigen::Matrix2d apart =
      first == last ? Eigen::Matrix2d(Eigen::Matrix2d::Zero())
                    : carried_to(first_R_map * arm(last), covariances.between(first, last));
  landmark.sigma_m = largest_sigma(first_R_map * own * first_R_map.transpose() + 0.25 * apart);
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
  mapping_ =
      map_landmarks(graph, seen, options_, [&](std::size_t node, const Eigen::Vector2d& point) {
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
  std::vector<std::vector<const LandmarkEdge*>> sightings(mapping.landmarks.size());
  for (const LandmarkEdge& edge : graph.landmark_edges)
    sightings[static_cast<std::size_t>(edge.landmark.index)].push_back(&edge);
  for (std::size_t i = 0; i < mapping.landmarks.size(); ++i)
    judge(mapping.landmarks[i], sightings[i], graph.poses, result.covariances);
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
