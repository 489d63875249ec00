#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/registration/correlative_search.hpp"
#include "registration/shift_sums.hpp"

namespace loopstone {

/// A search window cut into headings and whole-cell shifts around its centre. The scan turns about
/// its own centre of mass, so that a step of heading moves its points as little as can be.
struct SearchLattice {
  Eigen::Vector2d pivot;            ///< the scan's centre of mass, source frame
  Eigen::Vector2d pivot_in_target;  ///< where the window's centre puts it
  std::vector<double> headings{};
  double heading_step_rad = 0.0;
  int half_cells = 0;  ///< shifts run over [-half_cells, half_cells] in column and row
  double resolution_m = 0.0;

  [[nodiscard]] Pose2 pose_at(std::size_t heading, int column, int row) const;
};

/// \param source  not empty
[[nodiscard]] SearchLattice make_search_lattice(std::span<const Eigen::Vector2d> source,
                                                const GridFrame& frame, const SearchWindow& window);

/// The points from the scan's centre of mass.
[[nodiscard]] std::vector<Eigen::Vector2d> arms_of(std::span<const Eigen::Vector2d> source,
                                                   const SearchLattice& lattice);

/// The cells that the scan's points fall in at a heading, without a shift.
[[nodiscard]] CellList cells_at(std::span<const Eigen::Vector2d> arms, const GridFrame& frame,
                                const SearchLattice& lattice, std::size_t heading);

}  // namespace loopstone
