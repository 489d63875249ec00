#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/slam/graph_addition.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Maps the reflectors that a mapper's key scans show, and lets them hold its graph:
///
///   ReflectorMapper reflectors(options);
///   mapper.set_graph_addition(reflectors.addition());
///   const MapResult result = mapper.finish();
///   const LandmarkMapping landmarks = reflectors.settle(result);
///
/// The scans must have their intensities.
class ReflectorMapper {
 public:
  /// Throws OptionsError.
  explicit ReflectorMapper(const LandmarkMappingOptions& options);

  /// For Mapper::set_graph_addition; refers to this mapper, which must outlive it.
  [[nodiscard]] GraphAddition addition();
  /// Landmarks as the finished map has them, with the covariances of the poses that saw them. None
  /// where the run was interrupted before.
  [[nodiscard]] LandmarkMapping settle(const MapResult& result) const;

  [[nodiscard]] std::int64_t scans_with_intensities() const { return with_intensities_; }

 private:
  void add_to(PoseGraph& graph, std::span<const KeyView> keys);

  LandmarkMappingOptions options_;
  LandmarkMapping mapping_{};
  std::int64_t with_intensities_ = 0;
};

/// Whether a laser at a key scan saw beyond a point, robot frame: the beams about it end farther
/// away. Nothing: no beam goes there, something nearer hides it, or it is so far away that beams
/// may pass beside a thing of a hand's width.
[[nodiscard]] std::optional<bool> sees_through(const KeyView& key, const Eigen::Vector2d& point);

}  // namespace loopstone
