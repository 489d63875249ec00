#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// What scans are chosen and read by.
struct JudgedScanNumbers {
  double spacing_m = 0.2;
  double spacing_rad = 0.25;
  int most_scans = 1500;
  int most_beams = 120;
  int most_points = 240;
  double most_range_m = 15.0;
  double jump_m = 5.0;
  double neighbour_m = 0.25;
  double same_beam_m = 1e-3;
};
inline constexpr JudgedScanNumbers kJudgedScans{};

template <typename Visitor>
void visit_numbers(const JudgedScanNumbers& n, Visitor&& visit) {
  visit("spacing_m", n.spacing_m,
        "chosen: a scan nearer to the last one shows the same walls with the same pose error");
  visit("spacing_rad", n.spacing_rad, "chosen: the same of its heading");
  visit("most_scans", n.most_scans, "chosen: bounds the cost");
  visit("most_beams", n.most_beams, "chosen: bounds the cost; beams of a scan that are followed");
  visit("most_points", n.most_points, "chosen: bounds the cost; surface points of a scan");
  visit("most_range_m", n.most_range_m,
        "chosen: beyond, a degree of heading is more than a wall's place can tell about the map "
        "nearby");
  visit("jump_m", n.jump_m,
        "chosen: a robot does not drive so far between two scans; the log has a gap there, and the "
        "way is not known");
  visit("neighbour_m", n.neighbour_m,
        "chosen: neighbours tell a return's noise up to this far along the wall");
  visit(
      "same_beam_m", n.same_beam_m,
      "derived: a return and the point on its line differ across the wall only, but for rounding");
}

/// A return that lies on a piece of wall, map frame.
struct WallReturn {
  Eigen::Vector2f surface;   ///< on the line through its neighbours
  Eigen::Vector2f measured;  ///< where the beam ended
  Eigen::Vector2f normal;    ///< unit, towards the robot
};

/// A beam as the judge needs it, map frame.
struct JudgedBeam {
  Eigen::Vector2f start;
  Eigen::Vector2f end;
};

/// A scan that takes part in the judgement.
struct JudgedScan {
  int stretch = 0;
  Stamp stamp{};
  std::vector<WallReturn> returns{};
  std::vector<JudgedBeam> beams{};  ///< that ended on something
  std::vector<float> noise_m{};     ///< of single returns, from their neighbours
};

/// Chooses scans that are some way apart, at most a few thousand, and reads them. Stretches are
/// counted along the travel of all scans.
[[nodiscard]] std::vector<JudgedScan> judged_scans(std::span<const PosedScan> scans,
                                                   Threads threads);

}  // namespace loopstone
