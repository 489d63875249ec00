#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// A pose with its sine and cosine at hand.
struct PlacedKey {
  Eigen::Matrix2d rotation;
  Eigen::Vector2d translation;

  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2f& point) const {
    return rotation * point.cast<double>() + translation;
  }
};
[[nodiscard]] std::vector<PlacedKey> placed(std::span<const Pose2> map_T_key);

/// What one key scan saw of a patch: the mean of its points there.
struct PatchSight {
  int key = 0;
  float weight = 0.0F;
  Eigen::Vector2f point;  ///< robot frame of the key scan [m]
};

/// A piece of surface that at least two key scans saw.
struct SharedSurface {
  Eigen::Vector2d centre;  ///< mean of its points at the poses it was found with, map frame [m]
  Eigen::Vector2d normal;  ///< unit, mean of its points'
  std::size_t first = 0;   ///< its sights
  std::size_t last = 0;    ///< one past
};

struct SurfacePatches {
  std::vector<SharedSurface> patches;
  std::vector<PatchSight> sights;  ///< patch by patch, in the order of the key scans
};

/// Groups points that fall in one cell and face the same way (within 60 deg). Walls on a cell's
/// border would fall apart into two halves that nothing holds together, so there are two grids,
/// shifted by half a cell (Biber and Strasser 2003). The same for any number of threads.
[[nodiscard]] SurfacePatches find_patches(std::span<const PlacedKey> map_T_key,
                                          std::span<const std::vector<SurfacePoint>> surfaces,
                                          double patch_m, Threads threads = {});

/// A point is in a patch of either grid.
inline constexpr double kPatchGrids = 2.0;

/// What its patches know of each key scan's pose, in unit distances: H of open_translation().
[[nodiscard]] std::vector<Eigen::Matrix3d> key_hessians(std::span<const PlacedKey> map_T_key,
                                                        const SurfacePatches& patches);

/// Parts each patch where the path leads elsewhere before it comes back to see it again, and where
/// the path is broken; what only one key scan of a visit saw is dropped. Sights stay where they
/// are.
/// \param broken  of each key scan, whether the laser did not hold the path from the one before;
///                empty: nowhere
void part_by_visit(std::span<const Pose2> map_T_key, const std::vector<bool>& broken,
                   SurfacePatches& patches);

/// Parts each patch by what key scans belong to: of tied_parts(). Those of one part keep their
/// order; what only one key scan of a part saw is dropped.
void part_by(std::span<const int> part_of_key, SurfacePatches& patches);

}  // namespace loopstone
