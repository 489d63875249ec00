#include "localization/learned_beam_sensor.hpp"

#include <algorithm>
#include <initializer_list>

namespace loopstone {

namespace {

/// Of the scan's own laser.
RangeBeams beams_of(const LocalizationScan& scan) {
  const SeenByLaser& own = scan.lasers.front();
  return {own.robot_T_lidar, own.angles_rad, own.ranges_m};
}

}  // namespace

void LearnedBeamSensor::log_likelihoods(const LocalizationScan& scan,
                                        std::span<const Pose2> map_T_robot, std::span<double> out,
                                        Threads threads) {
  if (!model_) model_ = std::make_unique<BeamModel>(caster_, BeamModelOptions{.mixture = mixture_});
  model_->log_likelihoods(map_T_robot, beams_of(scan), out, threads);
}

void LearnedBeamSensor::learn_from(const LocalizationScan& scan, const Pose2& map_T_robot) {
  const std::vector<RangePair> pairs = range_pairs(caster_, map_T_robot, beams_of(scan));
  pairs_.insert(pairs_.end(), pairs.begin(), pairs.end());
  if (pairs_.size() < pairs_wanted_) return;
  const BeamLearningResult learned = learn_beam_mixture(pairs_, caster_.max_range_m(), mixture_);
  pairs_.clear();
  pairs_wanted_ *= 4;
  if (learned.status == BeamLearningStatus::kTooFewPairs) return;
  // Every part keeps a little weight: what was not seen yet may still come.
  constexpr double kLeastWeight = 0.01;
  mixture_ = learned.mixture;
  double sum = 0.0;
  for (double* weight : {&mixture_.hit_weight, &mixture_.short_weight, &mixture_.max_weight,
                         &mixture_.random_weight}) {
    *weight = std::max(*weight, kLeastWeight);
    sum += *weight;
  }
  for (double* weight : {&mixture_.hit_weight, &mixture_.short_weight, &mixture_.max_weight,
                         &mixture_.random_weight}) {
    *weight /= sum;
  }
  // Particles are sparser than a laser's noise is narrow.
  constexpr double kLeastSigmaM = 0.05;
  mixture_.hit_sigma_m = std::max(mixture_.hit_sigma_m, kLeastSigmaM);
  model_.reset();
}

}  // namespace loopstone
