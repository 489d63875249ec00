#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// When what one visit saw beats what others saw before.
struct VisitLedgerNumbers {
  double occupied = 0.65;
  double free = 0.35;
  int believed_after = 2;
  double trembles_m = 0.1;
  double fixed_share = 0.8;
  double changed_m = 0.15;
  int changed_cells = 10;
  double changed_gap_m = 0.25;
};
inline constexpr VisitLedgerNumbers kVisitLedger{};

template <typename Visitor>
void visit_numbers(const VisitLedgerNumbers& n, Visitor&& visit) {
  visit("occupied", n.occupied, "chosen: a visit that gives a cell more than this saw it occupied");
  visit("free", n.free, "chosen: and less than this, free");
  visit("believed_after", n.believed_after,
        "chosen: so many visits in a row must contradict a cell that several visits agreed on");
  visit("trembles_m", n.trembles_m,
        "chosen: nearer than this to something fixed a cell is taken for its edge, not for a thing "
        "that moves");
  visit("fixed_share", n.fixed_share, "chosen: what so many visits saw is fixed");
  visit("changed_m", n.changed_m,
        "chosen: nearer to what was there before nothing has changed: cells tremble by less");
  visit("changed_cells", n.changed_cells,
        "chosen: fewer cells that hang together are noise and no change");
  visit("changed_gap_m", n.changed_gap_m, "chosen: cells nearer to each other hang together");
}

/// What one cell was at each visit that saw it, in order.
struct CellVisits {
  std::uint16_t seen = 0;
  std::uint16_t occupied = 0;  ///< of those
  std::uint16_t newest = 0;    ///< visit that saw it last, counted from 1; 0: none did
  std::uint8_t in_a_row = 0;   ///< newest visits that agree with each other
  bool newest_is_occupied = false;
  bool is_occupied = false;  ///< what is believed
};

/// A place where two maps of one building differ.
struct MapChange {
  bool appeared = false;                          ///< else it is gone
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< bounds [m], map frame
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  double area_m2 = 0.0;  ///< of its cells
};

/// One building, seen again and again: what is seen again confirms, what is contradicted fades. A
/// cell is what several visits in a row say it is, not what most visits ever said: a wall that was
/// moved is gone after two visits that looked through it, however often it was seen before. What
/// one visit alone says counts only where none before it was of another mind.
class VisitLedger {
 public:
  /// Of the next visit, drawn from its scans alone. Its cells must be as wide as those before, and
  /// lie on the same grid (build_occupancy_map()'s do); throws UsageError when they do not.
  /// Cost: O(cells).
  void add(const OccupancyMap& visit);

  [[nodiscard]] std::size_t visits() const { return visits_; }
  /// On the frame of map(). Counts stop at 65535.
  [[nodiscard]] const Grid<CellVisits>& cells() const { return cells_; }
  /// What is believed: certain where visits agree, less so where they do not.
  [[nodiscard]] OccupancyMap map() const;
  /// Probability that something stands there on a visit, of cells where visits are not of one mind:
  /// doors, chairs, what is moved; 0 elsewhere.
  [[nodiscard]] Grid<float> movable() const;

 private:
  void cover(const GridFrame& frame);

  Grid<CellVisits> cells_{};
  std::size_t visits_ = 0;
};

/// Where a building differs from what it was: cells that are occupied now and were seen free, and
/// the other way round, in pieces. Largest first. Both of the same cells.
[[nodiscard]] std::vector<MapChange> changes_between(const OccupancyMap& before,
                                                     const OccupancyMap& now);

}  // namespace loopstone
