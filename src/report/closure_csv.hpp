#pragma once

#include <string>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Every place that was recognised or looked like it, with its evidence: a line of column names,
/// then one line a closure.
///
///   from_t_s,to_t_s,from_node,to_node,from_submap,to_submap,
///   x_m,y_m,yaw_rad,                                                from_T_to, as measured
///   xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2, its covariance, upper triangle, axes of
///   `from` score,second_score,overlap,agreement,chi2,by_appearance,accepted,state,reason
///
/// by_appearance and accepted are 0 or 1; second_score and chi2 are empty where there is none.
[[nodiscard]] std::string format_closure_csv(const MapResult& result);

}  // namespace loopstone
