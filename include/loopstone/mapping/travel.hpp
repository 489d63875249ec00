#pragma once

#include <cstdint>
#include <optional>

#include "loopstone/grid/grid.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// What counts as coming by, and how speeds are read from poses.
struct TravelNumbers {
  double away_m = 1.0;
  double speed_window_s = 0.6;
  double standing_m_s = 0.08;
  double gap_m = 1.0;
  double gap_s = 3.0;
};
inline constexpr TravelNumbers kTravel{};

template <typename Visitor>
void visit_numbers(const TravelNumbers& n, Visitor&& visit) {
  visit("away_m", n.away_m,
        "chosen: a robot that was elsewhere for so much of its way comes by again");
  visit("speed_window_s", n.speed_window_s,
        "chosen: over so long 1 cm of noise of a pose is 2 cm/s; over a scan of ten a second, 14");
  visit("standing_m_s", n.standing_m_s,
        "chosen: more than noise makes of a robot that stands; slower than any drives");
  visit("gap_m", n.gap_m, "chosen: a robot does not drive so far between two poses of its path");
  visit("gap_s", n.gap_s, "chosen: nor is known where it was for so long");
}

/// Of one cell.
struct CellTravel {
  std::uint16_t passes = 0;  ///< how often a robot came by; stops at 65535
  std::uint16_t timed = 0;   ///< of them, those that drove there and did not only stand or turn
  float speed_sum_m_s = 0.0F;

  /// Mean of the passes, each by its way over the time in which it moved [m/s]; nothing: none
  /// drove there.
  [[nodiscard]] std::optional<float> speed_m_s() const {
    if (timed == 0) return {};
    return speed_sum_m_s / static_cast<float>(timed);
  }
};

/// The floor that robots drove over, how often and how fast: a cell was driven where its centre
/// came under a robot's footprint.
class Travel {
 public:
  /// \param frame  of the result; its corner lies on a whole multiple of its resolution. What lies
  ///               beyond it is left out
  explicit Travel(const GridFrame& frame) : cells_(frame) {}

  /// A drive.
  /// \param path                map_T_robot; where it has a gap, nothing is known in between
  /// \param footprint_radius_m  less than what a path needs to touch each cell that it crosses
  ///                            counts as that
  /// Cost: O(cells under the footprint) for each step of half a cell.
  void add(const Trajectory& path, double footprint_radius_m);

  [[nodiscard]] const Grid<CellTravel>& cells() const { return cells_; }

 private:
  Grid<CellTravel> cells_;
};

}  // namespace loopstone
