#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// A thing of known place that a robot can tell from others, or not.
struct Landmark {
  int id = 0;
  Eigen::Vector2d position{0.0, 0.0};  ///< map frame [m]
};

/// A landmark as the robot sees it.
struct LandmarkSighting {
  double range_m = 0.0;
  double bearing_rad = 0.0;  ///< robot frame, counter-clockwise from x
  std::optional<int> id{};   ///< which landmark; nothing: it looks like all the others
};

/// How well a robot sees landmarks.
struct LandmarkSensor {
  double range_sigma_m = 0.1;
  double bearing_sigma_rad = 0.035;
  double max_range_m = 10.0;  ///< nothing is seen farther away
  double clutter_share =
      0.05;  ///< of sightings that are of no landmark, or of another one than they say
  double gate_chi2 =
      13.8;  ///< a sighting farther from a landmark is not of it; 99.9 % of a chi-square of 2
};

/// How sightings of landmarks depend on the robot's pose. Immutable.
///
/// A sighting is of its landmark with probability 1 - clutter_share, then range and bearing are
/// normal about the true ones; else it lies anywhere within max_range_m and around the robot.
/// Source: Thrun, Burgard and Fox 2005, sections 6.6 and 7.5 (maximum likelihood association,
/// mutual exclusion).
class LandmarkModel {
 public:
  /// Throws UsageError for an id that occurs twice, a position that is not finite, and a sensor out
  /// of its ranges.
  LandmarkModel(std::vector<Landmark> landmarks, const LandmarkSensor& sensor);

  [[nodiscard]] const std::vector<Landmark>& landmarks() const { return landmarks_; }
  [[nodiscard]] const LandmarkSensor& sensor() const { return sensor_; }

  /// Range and bearing of a landmark, by index, without noise.
  [[nodiscard]] LandmarkSighting expected(const Pose2& map_T_robot, std::size_t landmark) const;
  /// Derivative of (range, bearing) by (x, y, yaw) of map_T_robot.
  [[nodiscard]] Eigen::Matrix<double, 2, 3> jacobian(const Pose2& map_T_robot,
                                                     std::size_t landmark) const;
  /// Sighting less expected one: (range [m], bearing [rad], wrapped).
  [[nodiscard]] Eigen::Vector2d innovation(const Pose2& map_T_robot,
                                           const LandmarkSighting& sighting,
                                           std::size_t landmark) const;

  /// log p(sightings | pose): those with an id by their landmark, those without by the best
  /// association of all that uses no landmark twice. Never -inf: there is always clutter. Cost:
  /// O(sightings * landmarks).
  [[nodiscard]] double log_likelihood(const Pose2& map_T_robot,
                                      std::span<const LandmarkSighting> sightings) const;

  /// Which landmark, by index, each sighting is of; nothing: clutter.
  [[nodiscard]] std::vector<std::optional<std::size_t>> associate(
      const Pose2& map_T_robot, std::span<const LandmarkSighting> sightings) const;

  /// log p of a sighting that is clutter, the prior share included.
  [[nodiscard]] double log_clutter() const { return log_clutter_; }

  /// A pose from which this would be seen: anywhere on the circle around the landmark. Without an
  /// id, around any landmark.
  /// Source: Thrun, Burgard and Fox 2005, table 6.5. Throws UsageError when there is no such
  /// landmark.
  [[nodiscard]] Pose2 sample_pose(const LandmarkSighting& sighting, Rng& rng) const;

 private:
  [[nodiscard]] double squared_distance(const Pose2& map_T_robot, const LandmarkSighting& sighting,
                                        std::size_t landmark) const;
  [[nodiscard]] std::optional<std::size_t> index_of(int id) const;

  std::vector<Landmark> landmarks_;
  LandmarkSensor sensor_;
  std::unordered_map<int, std::size_t> index_of_id_;
  double log_normal_ = 0.0;   ///< (1 - clutter) times the peak of the normal density
  double log_clutter_ = 0.0;  ///< clutter times its density
};

}  // namespace loopstone
