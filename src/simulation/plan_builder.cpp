#include "simulation/plan_builder.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

void PlanBuilder::wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double thickness_m,
                       std::vector<Opening> openings) {
  std::sort(openings.begin(), openings.end(),
            [](const Opening& l, const Opening& r) { return l.at_m < r.at_m; });
  const Eigen::Vector2d along = b - a;
  const double length = along.norm();
  const double yaw = std::atan2(along.y(), along.x());
  const auto piece = [&](double from, double to) {
    if (to - from < 0.02) return;
    const Eigen::Vector2d middle = a + along * (0.5 * (from + to) / length);
    box({middle.x(), middle.y(), yaw}, to - from, thickness_m);
    world_.plan.boxes.back().is_wall = true;
  };
  // Walls meet at their centre lines; half a thickness more fills the corner.
  double from = -0.5 * thickness_m;
  for (const Opening& opening : openings) {
    piece(from, opening.at_m - 0.5 * opening.width_m);
    from = std::max(from, opening.at_m + 0.5 * opening.width_m);
  }
  piece(from, length + 0.5 * thickness_m);
}

void PlanBuilder::shell(double width_m, double depth_m, double thickness_m) {
  const double o = 0.5 * thickness_m;
  wall({-o, -o}, {width_m + o, -o}, thickness_m);
  wall({-o, depth_m + o}, {width_m + o, depth_m + o}, thickness_m);
  wall({-o, -o}, {-o, depth_m + o}, thickness_m);
  wall({width_m + o, -o}, {width_m + o, depth_m + o}, thickness_m);
  world_.floor_area_m2 += width_m * depth_m;
}

void PlanBuilder::box(const Pose2& building_T_box, double length_m, double width_m) {
  world_.plan.boxes.push_back({map_T_building_ * building_T_box, length_m, width_m});
}

void PlanBuilder::circle(const Eigen::Vector2d& centre, double radius_m) {
  world_.plan.circles.push_back({in_map(centre), radius_m});
}

void PlanBuilder::keep_out(const Pose2& building_T_box, double length_m, double width_m) {
  world_.keep_out.push_back({map_T_building_ * building_T_box, length_m, width_m});
}

void PlanBuilder::place(const Eigen::Vector2d& point) { world_.places.push_back(in_map(point)); }

void PlanBuilder::return_to(const Eigen::Vector2d& point) {
  world_.returns.push_back(in_map(point));
}

void PlanBuilder::start(const Pose2& building_T_start) {
  world_.map_T_start = map_T_building_ * building_T_start;
}

}  // namespace loopstone
