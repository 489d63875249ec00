#pragma once

#include <span>

#include "localization/learned_beam_sensor.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_options.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/localization/pose_belief.hpp"

namespace loopstone {

/// Weighs poses by a scan, by the sensor model that was asked for, and whole places.
class ScanWeigher {
 public:
  ScanWeigher(const LocalizationMap& map, ScanModel model, Threads threads);

  /// Log-likelihoods of the scan, as many readings as are independent.
  void log_likelihoods(const LocalizationScan& scan, std::span<const Pose2> map_T_robot,
                       std::span<double> out);
  [[nodiscard]] static double independent_readings(const LocalizationScan& scan);

  /// Log-likelihood of the scan in a place that has these poses: that of the best of them. For
  /// weighing places against each other.
  [[nodiscard]] double best_evidence(const LocalizationScan& scan,
                                     std::span<const Pose2> map_T_robot) const;
  /// From the best of a place's particles, or from where registration moves their mean.
  [[nodiscard]] double evidence_of(const LocalizationScan& scan, const PlaceBelief& place) const;

  /// A scan whose pose is sure teaches the beam model, if that is used.
  void learn_from(const LocalizationScan& scan, const Pose2& map_T_robot);

 private:
  const LocalizationMap& map_;
  ScanModel model_;
  Threads threads_;
  LearnedBeamSensor beam_sensor_;
};

}  // namespace loopstone
