#include "loopstone/localization/landmark_model.hpp"

#include <cmath>
#include <string>

#include "localization/assignment.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

LandmarkModel::LandmarkModel(std::vector<Landmark> landmarks, const LandmarkSensor& sensor)
    : landmarks_(std::move(landmarks)), sensor_(sensor) {
  if (!(sensor.range_sigma_m > 0.0 && sensor.bearing_sigma_rad > 0.0 && sensor.max_range_m > 0.0 &&
        sensor.clutter_share > 0.0 && sensor.clutter_share < 1.0 && sensor.gate_chi2 > 0.0)) {
    throw UsageError(
        "a landmark sensor needs noises, range and gate above zero and a clutter share between 0 "
        "and 1");
  }
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    if (!landmarks_[i].position.allFinite()) {
      throw UsageError("the position of landmark " + std::to_string(landmarks_[i].id) +
                       " is not finite");
    }
    if (!index_of_id_.emplace(landmarks_[i].id, i).second) {
      throw UsageError("landmark " + std::to_string(landmarks_[i].id) + " is given twice");
    }
  }
  log_normal_ = std::log((1.0 - sensor.clutter_share) /
                         (2.0 * kPi * sensor.range_sigma_m * sensor.bearing_sigma_rad));
  log_clutter_ = std::log(sensor.clutter_share / (2.0 * kPi * sensor.max_range_m));
}

LandmarkSighting LandmarkModel::expected(const Pose2& map_T_robot, std::size_t landmark) const {
  const Eigen::Vector2d way = landmarks_[landmark].position - map_T_robot.translation();
  return {.range_m = way.norm(),
          .bearing_rad = wrap_angle(std::atan2(way.y(), way.x()) - map_T_robot.yaw),
          .id = landmarks_[landmark].id};
}

// range = |m - t|, bearing = atan2(m - t) - yaw: Thrun 2005, table 7.2, line 12.
Eigen::Matrix<double, 2, 3> LandmarkModel::jacobian(const Pose2& map_T_robot,
                                                    std::size_t landmark) const {
  const Eigen::Vector2d way = landmarks_[landmark].position - map_T_robot.translation();
  const double square = std::max(way.squaredNorm(), 1e-12);
  const double range = std::sqrt(square);
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << -way.x() / range, -way.y() / range, 0.0, way.y() / square, -way.x() / square, -1.0;
  return jacobian;
}

Eigen::Vector2d LandmarkModel::innovation(const Pose2& map_T_robot,
                                          const LandmarkSighting& sighting,
                                          std::size_t landmark) const {
  const LandmarkSighting seen = expected(map_T_robot, landmark);
  return {sighting.range_m - seen.range_m, wrap_angle(sighting.bearing_rad - seen.bearing_rad)};
}

double LandmarkModel::squared_distance(const Pose2& map_T_robot, const LandmarkSighting& sighting,
                                       std::size_t landmark) const {
  const Eigen::Vector2d off = innovation(map_T_robot, sighting, landmark);
  const double range = off.x() / sensor_.range_sigma_m;
  const double bearing = off.y() / sensor_.bearing_sigma_rad;
  return range * range + bearing * bearing;
}

std::optional<std::size_t> LandmarkModel::index_of(int id) const {
  const auto found = index_of_id_.find(id);
  if (found == index_of_id_.end()) return std::nullopt;
  return found->second;
}

std::vector<std::optional<std::size_t>> LandmarkModel::associate(
    const Pose2& map_T_robot, std::span<const LandmarkSighting> sightings) const {
  std::vector<std::optional<std::size_t>> association(sightings.size());
  std::vector<bool> taken(landmarks_.size(), false);
  std::vector<std::size_t> nameless;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (!sightings[i].id) {
      nameless.push_back(i);
      continue;
    }
    const auto landmark = index_of(*sightings[i].id);
    if (!landmark || squared_distance(map_T_robot, sightings[i], *landmark) > sensor_.gate_chi2)
      continue;
    association[i] = landmark;
    taken[*landmark] = true;
  }
  // What believing in a landmark gains over believing in clutter.
  GainTable table{nameless.size(), landmarks_.size(),
                  std::vector<double>(nameless.size() * landmarks_.size(), 0.0)};
  for (std::size_t row = 0; row < nameless.size(); ++row) {
    for (std::size_t landmark = 0; landmark < landmarks_.size(); ++landmark) {
      if (taken[landmark]) continue;
      const double distance = squared_distance(map_T_robot, sightings[nameless[row]], landmark);
      if (distance > sensor_.gate_chi2) continue;
      table.gains[row * table.columns + landmark] = log_normal_ - 0.5 * distance - log_clutter_;
    }
  }
  const auto best = best_assignment(table);
  for (std::size_t row = 0; row < nameless.size(); ++row) association[nameless[row]] = best[row];
  return association;
}

double LandmarkModel::log_likelihood(const Pose2& map_T_robot,
                                     std::span<const LandmarkSighting> sightings) const {
  bool any_nameless = false;
  double sum = 0.0;
  for (const LandmarkSighting& sighting : sightings) {
    if (!sighting.id) {
      any_nameless = true;
      continue;
    }
    const auto landmark = index_of(*sighting.id);
    if (!landmark) {
      sum += log_clutter_;
      continue;
    }
    // log((1 - c) N + c p), the larger term outside.
    const double of_landmark =
        log_normal_ - 0.5 * squared_distance(map_T_robot, sighting, *landmark);
    const double more = std::max(of_landmark, log_clutter_);
    sum += more + std::log1p(std::exp(std::min(of_landmark, log_clutter_) - more));
  }
  if (!any_nameless) return sum;
  const auto association = associate(map_T_robot, sightings);
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (sightings[i].id) continue;
    sum += association[i]
               ? log_normal_ - 0.5 * squared_distance(map_T_robot, sightings[i], *association[i])
               : log_clutter_;
  }
  return sum;
}

Pose2 LandmarkModel::sample_pose(const LandmarkSighting& sighting, Rng& rng) const {
  const auto named = sighting.id ? index_of(*sighting.id) : std::nullopt;
  if (landmarks_.empty() || (sighting.id && !named)) {
    throw UsageError("the map has no landmark that this could be a sighting of");
  }
  const std::size_t landmark =
      named ? *named : static_cast<std::size_t>(rng.below(landmarks_.size()));
  const double around = rng.uniform(-kPi, kPi);
  const double range = sighting.range_m + rng.normal(0.0, sensor_.range_sigma_m);
  const double bearing = sighting.bearing_rad + rng.normal(0.0, sensor_.bearing_sigma_rad);
  const Eigen::Vector2d& position = landmarks_[landmark].position;
  return {position.x() + range * std::cos(around), position.y() + range * std::sin(around),
          wrap_angle(around - kPi - bearing)};
}

}  // namespace loopstone
