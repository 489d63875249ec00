#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/registration/map_match.hpp"

namespace loopstone {

/// A pose of the lattice of match_on_map and its score in [-1, 1].
struct LatticePose {
  Pose2 map_T_source{};
  double score = 0.0;
};

struct LatticePoses {
  std::vector<LatticePose>
      poses{};  ///< best first; the best of each block of shifts, not yet thinned
  std::int64_t evaluations = 0;
};

/// The lattice: headings that move the farthest point by one cell, and the centres of cells where a
/// robot can stand.
struct MapLattice {
  std::vector<double> headings{};
  Cell first{};  ///< of the window
  Cell last{};
};

[[nodiscard]] MapLattice make_map_lattice(std::span<const Eigen::Vector2d> points,
                                          const MapSearch& map,
                                          const std::optional<SearchWindow>& window);

/// All blocks of lattice poses whose best one scores at least min_score and within `margin` of the
/// best of all, each with that pose. Exact.
/// \param points  in an order such that any few of the first ones are spread over the scan
///
/// Beside search_branch_and_bound, which proves one best pose of a window, this is for whole maps
/// and for all answers at once: every block that comes near the best, of poses where a robot can
/// stand. On a map of 57 m x 57 m at 10 cm it takes 0.1 s; the other search 0.13 s for the best
/// pose and 0.19 s more to prove that there is or isn't a second one (medians of 14 scans of ACES),
/// and there were 8 to 888 blocks to tell.
[[nodiscard]] LatticePoses search_map_lattice(std::span<const Eigen::Vector2d> points,
                                              const MapSearch& map, const MapLattice& lattice,
                                              double min_score, double margin);

}  // namespace loopstone
