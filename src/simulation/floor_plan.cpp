#include "loopstone/simulation/floor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loopstone {

std::vector<Segment> outline(const Box& box) {
  const double l = 0.5 * box.length_m;
  const double w = 0.5 * box.width_m;
  const Eigen::Vector2d a = box.map_T_box * Eigen::Vector2d(-l, -w);
  const Eigen::Vector2d b = box.map_T_box * Eigen::Vector2d(l, -w);
  const Eigen::Vector2d c = box.map_T_box * Eigen::Vector2d(l, w);
  const Eigen::Vector2d d = box.map_T_box * Eigen::Vector2d(-l, w);
  return {{a, b}, {b, c}, {c, d}, {d, a}};
}

std::vector<Segment> flat_surfaces(const FloorPlan& plan) {
  std::vector<Segment> segments;
  segments.reserve(plan.boxes.size() * 4 + plan.surfaces.size());
  for (const Box& box : plan.boxes) {
    const auto sides = outline(box);
    segments.insert(segments.end(), sides.begin(), sides.end());
  }
  segments.insert(segments.end(), plan.surfaces.begin(), plan.surfaces.end());
  return segments;
}

Extent extent_of(const FloorPlan& plan) {
  if (plan.boxes.empty() && plan.circles.empty() && plan.surfaces.empty()) return {};
  const double infinity = std::numeric_limits<double>::infinity();
  Extent extent{{infinity, infinity}, {-infinity, -infinity}};
  const auto include = [&](const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    extent.low = extent.low.cwiseMin(low);
    extent.high = extent.high.cwiseMax(high);
  };
  for (const Segment& segment : flat_surfaces(plan)) {
    include(segment.from.cwiseMin(segment.to), segment.from.cwiseMax(segment.to));
  }
  for (const Circle& circle : plan.circles) {
    const Eigen::Vector2d radius(circle.radius_m, circle.radius_m);
    include(circle.centre - radius, circle.centre + radius);
  }
  return extent;
}

bool is_inside(const Box& box, const Eigen::Vector2d& point) {
  const Eigen::Vector2d p_box = box.map_T_box.inverse() * point;
  return std::abs(p_box.x()) <= 0.5 * box.length_m && std::abs(p_box.y()) <= 0.5 * box.width_m;
}

bool is_inside(const Circle& circle, const Eigen::Vector2d& point) {
  return (point - circle.centre).norm() <= circle.radius_m;
}

double distance_to(const Segment& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = segment.to - segment.from;
  const double squared_length = along.squaredNorm();
  const double ratio =
      squared_length > 0.0
          ? std::clamp((point - segment.from).dot(along) / squared_length, 0.0, 1.0)
          : 0.0;
  return (segment.from + ratio * along - point).norm();
}

double distance_to(const Circle& circle, const Eigen::Vector2d& point) {
  return std::abs((point - circle.centre).norm() - circle.radius_m);
}

}  // namespace loopstone
