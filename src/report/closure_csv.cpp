#include "report/closure_csv.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cstddef>
#include <iterator>
#include <optional>

#include "loopstone/formats/decimal_stamp.hpp"

namespace loopstone {

namespace {

std::string stamp_of(const MapResult& result, NodeId node) {
  const auto index = static_cast<std::size_t>(node.index);
  if (node.index < 0 || index >= result.node_stamps.size()) return {};
  return format_decimal_stamp(result.node_stamps[index]);
}

/// Empty where there is none.
std::string cell(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : std::string{};
}

}  // namespace

std::string format_closure_csv(const MapResult& result) {
  std::string csv =
      "from_t_s,to_t_s,from_node,to_node,from_submap,to_submap,x_m,y_m,yaw_rad,"
      "xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,"
      "score,second_score,overlap,agreement,chi2,by_appearance,accepted,state,reason\n";
  for (const LoopClosure& closure : result.loop_closures) {
    const Eigen::Matrix3d& p = closure.covariance;
    const auto out = std::back_inserter(csv);
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{},", stamp_of(result, closure.from),
                   stamp_of(result, closure.to), closure.from.index, closure.to.index,
                   closure.from_submap.index, closure.to_submap.index, closure.from_T_to.x,
                   closure.from_T_to.y, closure.from_T_to.yaw);
    fmt::format_to(out, "{},{},{},{},{},{},", p(0, 0), p(0, 1), p(0, 2), p(1, 1), p(1, 2), p(2, 2));
    // Reasons are our own words and hold no comma or quote.
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{}\n", closure.score, cell(closure.second_score),
                   closure.overlap, closure.agreement, cell(closure.chi2),
                   closure.by_appearance ? 1 : 0, closure.stands() ? 1 : 0,
                   to_string(closure.state), to_string(closure.reason));
  }
  return csv;
}

}  // namespace loopstone
