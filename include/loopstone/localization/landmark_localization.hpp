#pragma once

#include <functional>
#include <span>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/filter_health.hpp"
#include "loopstone/localization/landmark_model.hpp"
#include "loopstone/localization/renewal.hpp"

namespace loopstone {

/// When a landmark localizer calls its belief narrow, and how it checks itself.
struct LandmarkLocalizerOptions {
  double narrow_m = 0.3;     ///< standard deviation of the position
  double narrow_rad = 0.15;  ///< of the heading
  FilterHealthOptions health{};
  double confirm_quantile =
      3.0;  ///< as health.z_quantile: beyond it the estimate is not called converged
  Renewal<Pose2> renewal{};
};

/// Where the robot is after a reading, and whether to believe it.
struct LandmarkEstimate {
  PoseWithCovariance2 map_T_robot{};  ///< of (x, y, yaw), map axes
  FilterStatus status = FilterStatus::kConverging;
  FilterHealth health{};
  FilterStep step{};
  int sightings = 0;
  int explained = 0;  ///< sightings that a landmark of the map explains
};

/// Follows a robot by range and bearing to landmarks of known places, with a particle filter, and
/// tells when it fails: when the map is another one, the sensor is not as described, or the robot
/// is not where the particles are.
///
///   LandmarkLocalizer localizer(model, first_poses, {}, seed);
///   localizer.predict([&](const Pose2& pose, Rng& noise) {
///     return sample_odometry_motion(pose, motion, strays, noise);
///   });
///   const LandmarkEstimate estimate = localizer.update(sightings);
///   if (estimate.status == FilterStatus::kInconsistent) complain(reason(estimate.health));
class LandmarkLocalizer {
 public:
  /// \param first_poses  particles: where the robot may be, map_T_robot
  LandmarkLocalizer(LandmarkModel model, std::vector<Pose2> first_poses,
                    LandmarkLocalizerOptions options, std::uint64_t seed, Threads threads = {1});

  /// The robot moved: motion draws a pose after from a pose before.
  void predict(const std::function<Pose2(const Pose2& map_T_before, Rng& noise)>& motion);

  /// The robot looked around. Sightings that are not finite, or of a range that is not positive,
  /// are left out.
  LandmarkEstimate update(std::span<const LandmarkSighting> sightings);

  [[nodiscard]] const ParticleFilter<Pose2>& belief() const { return filter_; }
  [[nodiscard]] const LandmarkModel& model() const { return model_; }

 private:
  [[nodiscard]] bool narrow(const PoseWithCovariance2& belief) const;

  LandmarkModel model_;
  LandmarkLocalizerOptions options_;
  ParticleFilter<Pose2> filter_;
  FilterHealthMonitor monitor_;
  Rng rng_;
  Threads threads_;
};

/// What a belief says of sightings before they are taken in: their squared Mahalanobis distance,
/// and the evidence to expect.
/// \param prior        the belief before, narrow enough to be a normal distribution
/// \param association  which landmark each sighting is of, as LandmarkModel::associate tells
/// log_evidence and effective_share are left for the caller.
[[nodiscard]] FilterReading compare_with_prediction(
    const LandmarkModel& model, const PoseWithCovariance2& prior,
    std::span<const LandmarkSighting> sightings,
    std::span<const std::optional<std::size_t>> association);

}  // namespace loopstone
