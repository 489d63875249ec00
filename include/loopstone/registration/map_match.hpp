#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/field_match.hpp"
#include "loopstone/registration/likelihood_field.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

struct MapSearchOptions {
  double cell_m = 0.1;
  double tolerance_m = 0.1;
  double robot_radius_m = 0;
  MapFieldOptions field{};
};

template <typename Visitor>
void visit_options(MapSearchOptions& options, Visitor&& visit) {
  visit("cell_m", options.cell_m, Range{0.02, 1.0},
        "cell of the search; a whole multiple of the map's is best");
  visit("tolerance_m", options.tolerance_m, Range{0.01, 1.0},
        "a point so near to a wall counts in full, out to 2.5 times that less and less");
  visit("robot_radius_m", options.robot_radius_m, Range{0.0, 10.0},
        "places nearer to a wall are left out");
  visit.group("field", options.field);
}

/// A map made ready for finding scans on it, once: where walls are, how far each place is from one,
/// and where a robot can stand. Immutable, so it may be shared between threads.
class MapSearch {
 public:
  /// \param occupancy  in percent, -1 unknown, as nav_msgs/OccupancyGrid has it
  /// Cost and memory: about 50 ns and 7 bytes a cell of the map.
  explicit MapSearch(const Grid<std::int8_t>& occupancy, const MapSearchOptions& options = {});

  [[nodiscard]] const MapField& field() const { return field_; }
  /// The search grid with the meaning of kContradiction, kUnknown and kSurface, and its bounds.
  [[nodiscard]] const MaxPyramid& pyramid() const { return pyramid_; }
  /// 1 where a robot can stand, on the search grid.
  [[nodiscard]] const Grid<std::uint8_t>& standable() const { return standable_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  MapField field_;
  Grid<std::uint8_t> standable_;
  MaxPyramid pyramid_;
};

struct MapMatchOptions {
  double min_score = 0.4;
  double sure_score = 0.6;
  double sure_gap = 0.03;
  int poses_max = 5;
  int refined_max = 64;
  int points_max = 160;
  double range_max_m = 15.0;
  double distinct_m = 1.0;
  double distinct_rad = 0.35;
};

template <typename Visitor>
void visit_options(MapMatchOptions& options, Visitor&& visit) {
  visit("min_score", options.min_score, Range{-1.0, 1.0}, "poses that score less are left out");
  visit("sure_score", options.sure_score, Range{0.0, 1.0},
        "a best pose that explains less of the scan is never called sure");
  visit("sure_gap", options.sure_gap, Range{0.0, 1.0},
        "nor is one that explains no more than so much above the next best");
  visit("poses_max", options.poses_max, Range{1, 1000}, "distinct poses to return");
  visit("refined_max", options.refined_max, Range{1, 10000},
        "distinct poses of the lattice to refine, the best first");
  visit("points_max", options.points_max, Range{10, 2000},
        "points of the scan to search with; the refinement takes up to 400");
  visit("range_max_m", options.range_max_m, Range{1.0, 1000.0},
        "farther points only when there are few others: they make headings many");
  visit("distinct_m", options.distinct_m, Range{0.01, 100.0},
        "poses nearer to each other than this and distinct_rad are one");
  visit("distinct_rad", options.distinct_rad, Range{0.001, 3.2},
        "poses nearer to each other than this and distinct_m are one");
}

/// Where a scan fits on a map.
struct MapMatch {
  /// Distinct poses, best score first; refined, with covariances. match.score: share of the scan's
  /// points that lie on a wall with nothing in the way.
  std::vector<MatchResult> poses{};
  bool sure =
      /// there is a best pose, it explains the scan, and no other one explains it nearly as well
      false;
  bool complete = true;          ///< false: more places look alike than were refined or returned
  std::int64_t evaluations = 0;  ///< poses and blocks of poses that were scored in the search

  [[nodiscard]] bool found() const { return !poses.empty(); }
};

/// Finds a scan on a map, anywhere or in a window.
///
/// All poses of the search's lattice (cells of the map by headings that move the farthest point by
/// one cell) where a robot can stand are compared by branch and bound; those nearly as good as the
/// best are refined on the map's distance field and scored again, with every point and with what
/// stands between it and the laser.
///
/// \param source  a scan's returns in the laser's frame [m]: beams start at its origin
/// \param window  of the pose of that frame on the map; none: the whole map
/// \return the best few distinct poses. Nothing is dropped silently: a lattice pose that scores
///         within 0.12 of the best is refined, unless it is one of more than refined_max distinct
///         ones, and then the match isn't called sure.
/// Cost: about 0.3 s (0.8 at most) for 10,000 m2 and 1081 beams, 6 ms for a window of 1 m and 50
/// deg. Deterministic. Thread-safe.
/// Source: Olson 2009; Hess et al. 2016, section V; Kohlbrecher et al. 2011 for the refinement.
[[nodiscard]] MapMatch match_on_map(std::span<const Eigen::Vector2d> source, const MapSearch& map,
                                    const std::optional<SearchWindow>& window = {},
                                    const MapMatchOptions& options = {});

}  // namespace loopstone
