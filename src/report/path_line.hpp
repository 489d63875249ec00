#pragma once

#include <span>

#include "loopstone/odometry/trajectory.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"

namespace loopstone {

/// The path in the colours of time, from its first to its last pose.
/// \param lifted  stamps of poses to which no line leads: there another drive begins
void draw_path_line(const Trajectory& trajectory, const MapView& view, double width_px,
                    Canvas& canvas, std::span<const Stamp> lifted = {});

}  // namespace loopstone
