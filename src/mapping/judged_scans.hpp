#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

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
  std::vector<WallReturn> returns{};
  std::vector<JudgedBeam> beams{};  ///< that ended on something
  std::vector<float> noise_m{};     ///< of single returns, from their neighbours
};

/// Chooses scans that are some way apart, at most a few thousand, and reads them. Stretches are
/// counted along the travel of all scans.
[[nodiscard]] std::vector<JudgedScan> judged_scans(std::span<const PosedScan> scans,
                                                   Threads threads);

}  // namespace loopstone
