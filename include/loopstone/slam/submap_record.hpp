#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/slam/finished_submap.hpp"
#include "loopstone/slam/key_scan.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/mapped_scan.hpp"

namespace loopstone {

enum class SubmapState {
  kOpen,     ///< scans are still added
  kFrozen,   ///< full
  kDropped,  ///< older ones saw all of it: nothing is compared with it, its scans are thinned
};

constexpr SubmapState last_of(SubmapState) { return SubmapState::kDropped; }

/// All that the back end knows of a submap, from the first key scan on. Its stretch of the path
/// goes from that to where the next submap begins; the submap itself reaches farther.
struct SubmapRecord {
  std::vector<KeyScan> keys{};   ///< of its stretch; thinned: see KeyChain
  SharedScans scans{};           ///< of its stretch; thinned: those of keys
  PoseWithCovariance2 across{};  ///< motion from its first key scan to the next stretch's, or to
                                 ///< its own last
  double travelled_m = 0.0;      ///< along the path up to its first key scan, and what breaks count
  Pose2 map_T_submap{};          ///< of its first key scan
  SubmapState state = SubmapState::kOpen;
  /// Once it is full, until it is dropped.
  std::shared_ptr<const FrozenSubmap> frozen{};
  std::size_t piece = 0;                             ///< of the path; see FinishedSubmap
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of its surfaces, submap frame
  double radius_m = 0.0;                             ///< rms distance of its surfaces from it
  std::vector<SubmapId> closed_with{};               ///< by closures that stand
  std::vector<float> descriptor{};  ///< of the place, once somebody asked; follows from `frozen`

  /// It is full: takes over what the front end made of it.
  void freeze(FinishedSubmap submap);
  /// Nothing will be compared with it any more.
  void drop();
  [[nodiscard]] std::size_t surface_count() const { return frozen ? frozen->surfaces.size() : 0; }

  template <typename Archive>
  void archive(Archive& a) {
    a(keys, scans, across, travelled_m, map_T_submap, state, piece, centre, radius_m, closed_with);
    if (state != SubmapState::kFrozen) return;
    if constexpr (Archive::kReads) {
      FrozenSubmap read;
      a(read);
      frozen = std::make_shared<const FrozenSubmap>(std::move(read));
    } else {
      a(*frozen);
    }
  }
};

/// Whether something may be there; for what comes from a file. Angles are wrapped wherever poses
/// come from: far from that, solvers would wrap for ever.
[[nodiscard]] bool is_sound(const Pose2& pose);

/// Of each, in order.
[[nodiscard]] std::vector<Pose2> poses_of(std::span<const SubmapRecord> submaps);

}  // namespace loopstone
