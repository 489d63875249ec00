#pragma once

#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/scan_matcher.hpp"

namespace loopstone {

/// A pose worth a closer look.
struct Candidate {
  Pose2 target_T_source;
  double score = 0.0;  ///< [-1, 1]: points on surfaces less points in free space
};

/// The best distinct poses of a window, on a coarse lattice, best first: every pose of the lattice
/// is scored.
/// Cost: some tens of microseconds for a metre and 50 deg.
/// Source: Olson 2009, "Real-time correlative scan matching", its low resolution alone.
[[nodiscard]] std::vector<Candidate> search_window(const ScanView& source, const ScanView& target,
                                                   const Pose2& centre, double half_xy_m,
                                                   double half_yaw_rad, int count);

}  // namespace loopstone
