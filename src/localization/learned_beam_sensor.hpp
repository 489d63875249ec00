#pragma once

#include <memory>
#include <span>
#include <vector>

#include "loopstone/grid/sphere_caster.hpp"
#include "loopstone/localization/beam_model_learning.hpp"
#include "loopstone/localization/localization_scan.hpp"

namespace loopstone {

/// The beam model as a localizer uses it: it starts from a common mixture of its four parts, and
/// learns this laser's and this building's from the scans whose pose is sure.
class LearnedBeamSensor {
 public:
  /// \param caster  on the map
  explicit LearnedBeamSensor(const SphereCaster& caster) : caster_(caster) {}

  void log_likelihoods(const LocalizationScan& scan, std::span<const Pose2> map_T_robot,
                       std::span<double> out, Threads threads);

  /// A scan whose pose is sure. The mixture is learned from the first few thousand beams, and ever
  /// more seldom again.
  void learn_from(const LocalizationScan& scan, const Pose2& map_T_robot);

  [[nodiscard]] const BeamMixture& mixture() const { return mixture_; }

 private:
  RayCaster caster_;
  BeamMixture mixture_{};
  std::unique_ptr<const BeamModel> model_{};  ///< made when first needed
  std::vector<RangePair> pairs_{};
  std::size_t pairs_wanted_ = 5000;
};

}  // namespace loopstone
