#include "report/trajectory_csv.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <iterator>

#include "loopstone/formats/decimal_stamp.hpp"

namespace loopstone {

std::string format_trajectory_csv(const MapResult& result) {
  std::string text = "t_s,x_m,y_m,yaw_rad,xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2\n";
  for (const StampedPose2& at : result.trajectory.poses()) {
    const Eigen::Matrix3d covariance = result.covariance_at(at.stamp);
    text += format_decimal_stamp(at.stamp);
    for (const double value : {at.pose.x, at.pose.y, at.pose.yaw})
      fmt::format_to(std::back_inserter(text), ",{:.6f}", value);
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column)
        fmt::format_to(std::back_inserter(text), ",{:.5g}", covariance(row, column) + 0.0);
    }
    text += '\n';
  }
  return text;
}

}  // namespace loopstone
