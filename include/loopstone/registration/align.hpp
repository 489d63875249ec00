#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/registration/align_options.hpp"
#include "loopstone/registration/cloud_extent.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "loopstone/registration/map_match.hpp"
#include "loopstone/registration/match_result.hpp"
#include "loopstone/registration/match_sweep.hpp"
#include "loopstone/sensor/laser_scan.hpp"

// The simple call on top of the matchers: it picks those that suit what is aligned and what is
// known.
namespace loopstone {

enum class AlignMethod {
  kAuto,         ///< what suits both sides, see align()
  kIcpPoint,     ///< iterated closest points to points,
  kIcpLine,      ///< to the segments between them, in the plane alone,
  kIcpPlane,     ///< to fitted lines or planes,
  kGicp,         ///< or planes of both sides
  kCorrelative,  ///< every pose of a window (branch and bound), refined; in the plane alone
  kGrid,         ///< Gauss-Newton on a grid, of a map or another scan; in the plane alone
};

constexpr auto words_of(AlignMethod /*any*/) {
  using enum AlignMethod;
  return std::array{Word{kAuto, "auto"},        Word{kIcpPoint, "icp_point"},
                    Word{kIcpLine, "icp_line"}, Word{kIcpPlane, "icp_plane"},
                    Word{kGicp, "gicp"},        Word{kCorrelative, "correlative"},
                    Word{kGrid, "grid"}};
}

/// What is known, and what is wanted.
template <int kDimension>
struct AlignRequest {
  using Pose = typename RigidMotion<kDimension>::Pose;

  AlignMethod method = AlignMethod::kAuto;
  std::optional<Pose> guess{};          ///< of target_T_source; none: nothing is known
  bool from_centroids = false;          ///< the guess lays the centroids on one another
  std::optional<double> search_xy_m{};  ///< the guess may be this wrong in x and in y, in the plane
  std::optional<double> search_yaw_rad{};  ///< and its heading this much; one alone: 1 m, 0.35 rad
  bool anywhere = false;                   ///< no guess at all: search everywhere
  int sweep_yaw = 0;  ///< match from so many headings around the guess, and tell how many agree
  /// Of the matchers; none: align_options_for() of what is aligned.
  std::optional<AlignOptions<kDimension>> options{};
  Threads threads{1};

  [[nodiscard]] bool searches() const { return search_xy_m || search_yaw_rad; }
  [[nodiscard]] bool is_guessed() const { return guess || from_centroids; }
};

/// What came of it, and of what was done.
template <int kDimension>
struct AlignResult {
  using Pose = typename RigidMotion<kDimension>::Pose;

  BasicMatchResult<kDimension> match{};
  Pose guess{};  ///< that the match began at
  /// What gave the answer: "scans" (match_scans), "search" (search_alignment), or as AlignMethod is
  /// called.
  std::string method{};
  CloudExtent<kDimension> source{};
  std::optional<SweepResult<kDimension>> sweep{};         ///< with sweep_yaw
  std::optional<CloudSearchResult<kDimension>> search{};  ///< of clouds, from no guess
  std::optional<MapMatch> map_match{};                    ///< on a map; poses of the source's frame
};

/// A scan of a robot, as it was driven.
struct RobotScan {
  LaserScan scan{};
  Pose2 robot_T_lidar{};
  Tangent2 velocity = Tangent2::Zero();  ///< of the robot, own frame [m/s, m/s, rad/s]
};

/// Aligns source to target; both may be scans (then poses are the robot's), points, or the target a
/// map (occupancy in percent, -1 unknown). kAuto does
///
///   scan to scan  match_scans: a search about the guess, then Gauss-Newton
///   scan to map   from a guess Gauss-Newton on the map's distances; in the window of search_xy_m;
///                 without either anywhere (match_on_map)
///   points        ICP to lines or planes from the guess; without one from the better of identity
///                 and centroids, and by search_alignment where neither ends at a pose that the
///                 data support; branch and bound in a window
///
/// \return match, of which a failure is a status: kTooFewPairs and kNotConverged are no match. On a
///         map where another pose explains the scan as well it is kDegenerate.
/// Throws UsageError for a method that does not go with the two sides or with the search that is
/// asked for.
/// Cost: of the matchers, docs/matching.md. Deterministic: the same bytes for any number of
/// threads.
/// Thread-safe.
[[nodiscard]] AlignResult<2> align(const RobotScan& source, const RobotScan& target,
                                   const AlignRequest<2>& request = {});
[[nodiscard]] AlignResult<2> align(const RobotScan& source, const Grid<std::int8_t>& map,
                                   const AlignRequest<2>& request = {});
[[nodiscard]] AlignResult<2> align(std::span<const Eigen::Vector2d> source,
                                   const Grid<std::int8_t>& map,
                                   const AlignRequest<2>& request = {});
[[nodiscard]] AlignResult<2> align(std::span<const Eigen::Vector2d> source,
                                   std::span<const Eigen::Vector2d> target,
                                   const AlignRequest<2>& request = {});
[[nodiscard]] AlignResult<3> align(std::span<const Eigen::Vector3d> source,
                                   std::span<const Eigen::Vector3d> target,
                                   const AlignRequest<3>& request = {});

}  // namespace loopstone
