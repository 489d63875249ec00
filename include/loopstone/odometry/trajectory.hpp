#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

struct StampedPose2 {
  Stamp stamp;
  Pose2 pose;
};

/// Poses ordered by stamp, strictly increasing.
class Trajectory {
 public:
  Trajectory() = default;
  /// Sorts by stamp; of several poses with one stamp the last given stays.
  explicit Trajectory(std::vector<StampedPose2> poses);

  /// Appends; stamps must increase (a pose with the last stamp replaces it; an earlier one is
  /// refused: false).
  bool append(Stamp stamp, const Pose2& pose);
  /// Makes room for so many poses.
  void reserve(std::size_t count) { poses_.reserve(count); }

  [[nodiscard]] const std::vector<StampedPose2>& poses() const { return poses_; }
  [[nodiscard]] bool empty() const { return poses_.empty(); }
  [[nodiscard]] std::size_t size() const { return poses_.size(); }
  [[nodiscard]] const StampedPose2& front() const { return poses_.front(); }
  [[nodiscard]] const StampedPose2& back() const { return poses_.back(); }

  /// The pose at a stamp, along the arc between its neighbours; nothing outside the covered time.
  [[nodiscard]] std::optional<Pose2> at(Stamp stamp) const;
  /// As at(), but before the start the first pose and after the end the last one. Nothing when
  /// empty.
  [[nodiscard]] std::optional<Pose2> at_clamped(Stamp stamp) const;
  /// The pose with exactly this stamp, within the tolerance; the nearest of several.
  [[nodiscard]] std::optional<Pose2> nearest(Stamp stamp, Duration tolerance) const;

  /// Sum of the distances between consecutive positions [m].
  [[nodiscard]] double path_length_m() const;

 private:
  std::vector<StampedPose2> poses_{};
};

}  // namespace loopstone
