#pragma once

#include "loopstone/odometry/trajectory.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"

namespace loopstone {

/// The path in the colours of time, from its first to its last pose.
void draw_path_line(const Trajectory& trajectory, const MapView& view, double width_px,
                    Canvas& canvas);

}  // namespace loopstone
