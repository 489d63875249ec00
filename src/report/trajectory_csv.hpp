#pragma once

#include <string>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// The path with its covariances, comma-separated: a line of column names, then one line a scan.
///
///   t_s,x_m,y_m,yaw_rad,
///     map_T_robot
///   xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2
///     its covariance against the first pose, axes of the map, upper triangle
[[nodiscard]] std::string format_trajectory_csv(const MapResult& result);

}  // namespace loopstone
