#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"

namespace loopstone {

struct LikelihoodFieldOptions {
  double hit_sigma_m = 0.1;       ///< standard deviation of a return about its wall
  double random_share = 0.5;      ///< of the returns that come from anywhere
  double max_range_m = 30.0;      ///< random returns spread evenly up to here
  double max_distance_m = 2.0;    ///< farther from every wall makes no difference
  double agree_distance_m = 0.5;  ///< beam skipping: farther from every wall is a disagreement
  int occupied_percent = 65;      ///< cells of this occupancy or more are walls
};

/// When a point is left out for all poses.
struct BeamSkipOptions {
  double max_disagreeing_share = 0.7;  ///< of the poses; a point with more is left out
  double max_skipped_share = 0.9;      ///< of the points; when more would go, all are kept
};

/// What beam skipping left out.
struct BeamSkipResult {
  std::vector<std::uint8_t> kept{};  ///< one a point: 1 it was weighed, 0 it was left out
  std::size_t skipped = 0;           ///< points left out
  bool gave_up = false;  ///< too many would have gone, so all were kept: a wrong place, not people
};

/// How well a scan fits a map from each of many poses: the sensor model that particles are weighed
/// with.
///
/// A point at distance d from the nearest wall has the log-likelihood log(hit_share * N(d; 0,
/// hit_sigma) + random_share / max_range), less its value on the wall, so that 0 is the best and
/// nothing is above. Walls are what a laser can have hit (visible_walls). Unknown cells and
/// everything outside the map: log(1 / max_range), the density of a return that the map says
/// nothing about; an unknown cell close to a wall has the wall's value where that is greater, since
/// faces are only known to a cell.
///
/// Values are looked up by cell, in steps of step(): 255 steps from the best to the worst. The sum
/// over points is one of whole numbers, and every rounding before it is the same for all
/// instruction sets, so results are the same bytes on any x86-64 or ARM processor and for any
/// number of threads. Coordinates are float in units of cells: a point within about 1e-3 cells of
/// an edge may count to the neighbour.
///
/// Memory: 2 bytes a cell, one of them for beam skipping alone. Cost to build: O(cells), about 50
/// ns each.
/// Cost: O(poses * points). With AVX2 a look-up is 6 instructions, a third of them loads, and about
/// 1 ns where the cells looked at fit a processor's second cache; poses are taken in an order that
/// keeps neighbours together. From 10,000 poses all over a map of 9 MB with few points it is
/// waiting for the third cache, about 6 ns each (docs/benchmarks.md).
/// Source: Thrun, Burgard and Fox 2005, table 6.3 and section 6.4 (unknown space); beam skipping as
/// in AMCL's likelihood_field_prob.
class LikelihoodFieldModel {
 public:
  /// \param occupancy  in percent, -1 unknown, as nav_msgs/OccupancyGrid has it
  /// Throws UsageError for a map of more than 2^31 cells or 2^22 cells a side.
  explicit LikelihoodFieldModel(const Grid<std::int8_t>& occupancy,
                                const LikelihoodFieldOptions& options = {}, Threads threads = {});
  /// \param distances_m  from each cell to the nearest wall; NaN: unknown
  explicit LikelihoodFieldModel(const Grid<float>& distances_m,
                                const LikelihoodFieldOptions& options = {}, Threads threads = {});

  /// One log-likelihood a pose, the sum over all points: as if they were independent, which they
  /// are not, so scale it.
  ///
  /// \param map_T_robot   |yaw| below 1e6. A pose that is not finite sees every point outside the
  ///                      map.
  /// \param points_robot  in the robot frame [m]; a point that is not finite counts as outside the
  ///                      map
  /// \param out           one a pose [nats], at most about 0
  /// Throws UsageError where the sizes of poses and out differ.
  void log_likelihoods(std::span<const Pose2> map_T_robot,
                       std::span<const Eigen::Vector2f> points_robot, std::span<double> out,
                       Threads threads = {1}) const;

  /// The same without the points that disagree with the map for most of the poses: people, moved
  /// furniture. For poses that are close together; from poses all over the map every point
  /// disagrees. A point disagrees when it falls on a known cell farther than agree_distance_m from
  /// every wall.
  BeamSkipResult log_likelihoods_skipping(std::span<const Pose2> map_T_robot,
                                          std::span<const Eigen::Vector2f> points_robot,
                                          std::span<double> out, const BeamSkipOptions& skip = {},
                                          Threads threads = {1}) const;

  /// Of one point in one cell, in steps below the best; any cell, outside the map too.
  [[nodiscard]] int cost(Cell cell) const;
  /// A log-likelihood is -step() times a cost [nats].
  [[nodiscard]] double step() const { return step_; }
  /// Whether a point in the cell speaks against the map.
  [[nodiscard]] bool disagrees(Cell cell) const;

  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  [[nodiscard]] std::size_t memory_bytes() const { return costs_.size() + disagreements_.size(); }

 private:
  void build(const Grid<float>& distances_m, const std::vector<std::uint8_t>& unknown,
             const LikelihoodFieldOptions& options, Threads threads);
  [[nodiscard]] std::size_t index_of(Cell cell) const;

  GridFrame frame_{};
  double step_ = 0.0;
  int padded_rows_ = 0;
  // With a border of one cell that stands for everything outside, in strips of 8 columns, so that a
  // cache line holds a square of 8 x 8 cells.
  std::vector<std::uint8_t> costs_{};
  std::vector<std::uint8_t> disagreements_{};
};

}  // namespace loopstone
