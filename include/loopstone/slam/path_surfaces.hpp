#pragma once

#include <memory>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

class SurfaceSystem;

/// Where a path was not held by the laser when it was tracked: of each key scan, or empty for
/// nowhere.
struct PathWeakness {
  std::vector<bool> broken{};  ///< nothing held the motion from the one before
  std::vector<bool> open{};    ///< a direction of it was left to odometry
};

/// What the surfaces that key scans share say of the path by itself, as if each visit of a place
/// had seen walls of its own: it tells how far parts may be off that no second visit ties. Copies
/// share what they know. Not thread-safe.
class PathSurfaces {
 public:
  /// Knows nothing.
  PathSurfaces() = default;
  /// \param map_T_key  where it was linearised
  /// \param places     of each key scan in the system, -1 where it is held
  /// \param size       of the system
  /// \param weakness   of the path to each key scan
  /// \param by_visit   of patches that no two visits share, and none over a break that the path
  ///                   does not tie by itself
  PathSurfaces(std::span<const Pose2> map_T_key, std::span<const int> places, std::size_t size,
               const PathWeakness& weakness, const SurfaceSystem& by_visit);

  [[nodiscard]] bool available() const { return knowledge_ != nullptr; }
  /// Where it was linearised.
  [[nodiscard]] std::span<const Pose2> poses() const;

  struct Knowledge;
  [[nodiscard]] Knowledge& knowledge() const { return *knowledge_; }

 private:
  std::shared_ptr<Knowledge> knowledge_{};
};

}  // namespace loopstone
