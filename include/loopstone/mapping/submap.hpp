#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/block_grid.hpp"
#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

struct SubmapOptions {
  double cell_m = 0.10;
  double search_cell_m = 0.10;
  double free_cell_m = 0.20;
  double no_return_carve_m = 5.0;
};

template <typename Visitor>
void visit_options(SubmapOptions& options, Visitor&& visit) {
  visit("cell_m", options.cell_m, Range{0.01, 1.0},
        "finest cell of the surfaces that scans are aligned to");
  visit("search_cell_m", options.search_cell_m, Range{0.02, 1.0},
        "cell of the grid that loop closing searches");
  visit("free_cell_m", options.free_cell_m, Range{0.02, 1.0}, "cell of the record of free space");
  visit("no_return_carve_m", options.no_return_carve_m, Range{0.0, 100.0},
        "a beam without return frees space up to this far");
}

/// What remains of a submap once it is full: its surfaces, thinned, and the space seen to be free.
/// A few tens of kilobytes; grids for matching and searching are rebuilt from it when they are
/// needed.
struct FrozenSubmap {
  std::vector<SurfacePoint> surfaces;  ///< submap frame
  Grid<std::uint8_t> free;             ///< 1 where beams passed and nothing was ever hit

  /// The finest level only: for a pose that is already good to half a cell or so.
  [[nodiscard]] SurfaceGrid surface_grid(const SubmapOptions& options) const;
  /// With as many levels as a window of that half side can use.
  [[nodiscard]] MaxPyramid search_pyramid(const SubmapOptions& options, double half_window_m) const;
  /// Whether nothing of it lies farther than this from its origin along either axis, or is no
  /// number; for what comes from a file.
  [[nodiscard]] bool lies_within(double reach_m) const;
  /// About `count` positions of its surfaces, evenly spaced, to search other submaps with.
  [[nodiscard]] std::vector<Eigen::Vector2d> probe(std::size_t count) const;

  template <typename Archive>
  void archive(Archive& a) {
    a(surfaces, free);
  }
};

/// A short stretch of travel within which dead reckoning and matching hardly drift, as surfaces to
/// align the next scan to. Its frame is the pose of its first scan.
class Submap {
 public:
  explicit Submap(const SubmapOptions& options);

  /// \param surfaces  of the scan, robot frame
  /// \param scan      for its free beams
  void insert(std::span<const SurfacePoint> surfaces, const LaserScan& scan,
              const Pose2& robot_T_lidar, const Pose2& submap_T_robot, BeamTable& beams);

  [[nodiscard]] const SurfaceGrid& surfaces() const { return state_.surfaces; }
  [[nodiscard]] FrozenSubmap freeze() const;

  /// What was inserted.
  struct State {
    SurfaceGrid surfaces{};
    BlockGrid<SurfaceCell> thin_surfaces{1.0};  ///< pieces that freeze() keeps
    BlockGrid<std::uint8_t> free{1.0};          ///< 1 where a beam passed

    template <typename Archive>
    void archive(Archive& a) {
      a(surfaces, thin_surfaces, free);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when its grids are not those of this submap's options.
  void restore(State state);

 private:
  SubmapOptions options_;
  State state_;
};

}  // namespace loopstone
