#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "slam/loop_coverage.hpp"

namespace loopstone {

/// What the surroundings of a closure must say for it.
struct LoopSurroundingsNumbers {
  std::size_t reach = 4;
  std::size_t beside = 2;
  double near_radii = 0.7;
  std::size_t probe_points = 200;
  double slack_m = 0.3;
  double slack_rad = 0.03;
  double on_surface_m = 0.08;
  double least_share = 0.45;
  double least_surfaces = 10.0;
};
inline constexpr LoopSurroundingsNumbers kLoopSurroundings{};

template <typename Visitor>
void visit_numbers(const LoopSurroundingsNumbers& n, Visitor&& visit) {
  visit("reach", n.reach, "chosen: submaps before and after each end of a closure that are asked");
  visit("beside", n.beside, "chosen: submaps this close in sequence share scans: they are not");
  visit("near_radii", n.near_radii,
        "chosen: two submaps nearer than this share of both their radii show parts of one place");
  visit("probe_points", n.probe_points, "chosen: surfaces of a submap that the search uses");
  visit("slack_m", n.slack_m,
        "chosen: how far the path between a closure's end and the submaps around may be off");
  visit("slack_rad", n.slack_rad, "chosen: the same of the heading");
  visit("on_surface_m", n.on_surface_m,
        "chosen: a surface this near to one that faces the same way is that one; two widths of "
        "the matcher's kernel");
  visit(
      "least_share", n.least_share,
      "chosen: of the surfaces that face along the correction; where somebody walks ahead in bare "
      "corridors, and in ACES without odometry, 0.58 to 0.93 of those of true closures lay on "
      "others, 0.07 to 0.3 of those of false ones");
  visit("least_surfaces", n.least_surfaces, "chosen: fewer hold nothing along the correction");
}

/// What the surfaces of places say about others that are laid over them, by where they face.
struct SurfaceWitness {
  static constexpr std::size_t kBins = 12;  ///< of the half circle, map frame
  std::array<double, kBins> seen{};         ///< surfaces that fall where the other one looked
  std::array<double, kBins> matched{};      ///< of those, on one that faces the same way

  void add(const SurfaceWitness& other);
};

/// Surfaces that face along a direction, to within 60 degrees.
[[nodiscard]] double facing(const std::array<double, SurfaceWitness::kBins>& surfaces,
                            const Eigen::Vector2d& direction);

/// What the submaps around both ends of a closure say of one another when those around the newer
/// end are moved as it asks. Walls along a corridor agree wherever one slides along it; what
/// tells a place there are the few surfaces that face along it.
/// Cost: some milliseconds a pair of submaps, of which there are up to (2 reach + 1)^2.
[[nodiscard]] SurfaceWitness surroundings_of(const LoopClosure& closure,
                                             std::span<const SubmapRecord> submaps,
                                             const SubmapOptions& options,
                                             const GridMatchOptions& match);

/// What surfaces of places fall on where others that are laid over them looked, by their weights.
struct SurfaceFit {
  double on = 0.0;     ///< a surface that faces the same way
  double off = 0.0;    ///< beside such a one
  double empty = 0.0;  ///< free space

  SurfaceFit& operator+=(const SurfaceFit& other);
  SurfaceFit& operator*=(double factor);
  [[nodiscard]] double seen() const { return on + off + empty; }
  [[nodiscard]] double share() const { return on > 0.0 ? on / seen() : 0.0; }
};

/// A submap's grids, built once for all that are laid over it.
class SubmapTarget {
 public:
  /// \param half_xy_m  as far as a search goes on them
  SubmapTarget(const FrozenSubmap& submap, const SubmapOptions& options, double half_xy_m)
      : cells_(submap.search_pyramid(options, half_xy_m)),
        surfaces_(submap.surface_grid(options)) {}

  [[nodiscard]] SubmapGrids grids() const { return {cells_, surfaces_}; }

 private:
  MaxPyramid cells_;
  SurfaceGrid surfaces_;
};

/// How two submaps lie on each other, each asked of the other, once they are settled.
/// \param older_T_newer  good to kLoopSurroundings.slack_m and slack_rad
/// \param near_m         surfaces farther from a submap's first scan say nothing: small turns of
///                       its scans move them by more than places differ
/// Cost: some milliseconds.
[[nodiscard]] SurfaceFit fit_of(const FrozenSubmap& older, const FrozenSubmap& newer,
                                const Pose2& older_T_newer, double near_m,
                                const SubmapOptions& options, const GridMatchOptions& match);
/// The same where both ones' grids are there already.
/// \param on_older  good for a search of kLoopSurroundings.slack_m
[[nodiscard]] SurfaceFit fit_of(const FrozenSubmap& older, const SubmapTarget& on_older,
                                const FrozenSubmap& newer, const SubmapTarget& on_newer,
                                const Pose2& older_T_newer, double near_m,
                                const GridMatchOptions& match);

/// How well two submaps agree at a pose: the share of one's surfaces that fall on the other's, of
/// those that fall where that one looked; of both the lesser. The other side of a thin wall says
/// nothing.
/// Cost: a millisecond or two.
[[nodiscard]] double agreement_of(const FrozenSubmap& older, const FrozenSubmap& newer,
                                  const Pose2& older_T_newer, const SubmapOptions& options);
/// The same where the older one's grids are there already.
[[nodiscard]] double agreement_of(const FrozenSubmap& older, const SubmapGrids& on_older,
                                  const FrozenSubmap& newer, const Pose2& older_T_newer,
                                  const SubmapOptions& options);

/// Whether the surroundings hold a closure in every direction in which it pulls.
/// \param map_pull  by how much it insists on moving its newer end [m], map frame
[[nodiscard]] bool hold(const SurfaceWitness& surroundings, const Eigen::Vector2d& map_pull,
                        double harmless_m);

}  // namespace loopstone
