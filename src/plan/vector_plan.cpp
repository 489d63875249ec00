#include "loopstone/plan/vector_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loopstone {

VectorPlan operator*(const Pose2& b_T_a, const VectorPlan& in_a) {
  VectorPlan moved = in_a;
  for (PlanSegment& segment : moved.segments) {
    segment.from = b_T_a * segment.from;
    segment.to = b_T_a * segment.to;
  }
  for (PlanDoor& door : moved.doors) {
    door.from = b_T_a * door.from;
    door.to = b_T_a * door.to;
  }
  for (PlanRoom& room : moved.rooms) {
    room.outline.polygon = b_T_a * room.outline.polygon;
    for (PlanOutline& hole : room.holes) hole.polygon = b_T_a * hole.polygon;
  }
  constexpr double kQuarter = 0.5 * kPi;
  for (PlanAxis& axis : moved.axes)
    axis.yaw_rad = std::remainder(axis.yaw_rad + b_T_a.yaw, kQuarter);
  return moved;
}

Pose2 straight_T_map(const VectorPlan& plan) {
  return plan.axes.empty() ? Pose2{} : Pose2{0.0, 0.0, -plan.axes.front().yaw_rad};
}

double length_of(const VectorPlan& plan, PlanLayer layer) {
  double sum = 0.0;
  for (const PlanSegment& segment : plan.segments)
    if (segment.layer == layer) sum += segment.length_m();
  return sum;
}

namespace {

/// From a point to the outline and the holes of a room; negative outside.
double room_around(const PlanRoom& room, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::infinity();
  bool inside = contains(room.outline.polygon, point);
  const auto look = [&](const Polygon2& polygon) {
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      const Eigen::Vector2d a = polygon.corners[i];
      const Eigen::Vector2d side = polygon.corners[(i + 1) % polygon.corners.size()] - a;
      const double length2 = side.squaredNorm();
      const double t = length2 > 0.0 ? std::clamp((point - a).dot(side) / length2, 0.0, 1.0) : 0.0;
      least = std::min(least, (point - a - t * side).norm());
    }
  };
  look(room.outline.polygon);
  for (const PlanOutline& hole : room.holes) {
    look(hole.polygon);
    inside = inside && !contains(hole.polygon, point);
  }
  return inside ? least : -least;
}

}  // namespace

Eigen::Vector2d label_place(const PlanRoom& room) {
  if (room.outline.polygon.corners.empty()) return {0.0, 0.0};
  Eigen::Vector2d low = room.outline.polygon.corners.front();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& corner : room.outline.polygon.corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  // A lattice over the whole room, then finer ones about the best so far. Of places that are
  // nearly as good, the one nearest to the middle.
  const Eigen::Vector2d middle = 0.5 * (low + high);
  Eigen::Vector2d best = middle;
  Eigen::Vector2d half = 0.5 * (high - low);
  const double size = half.norm();
  for (int round = 0; round < 3; ++round) {
    constexpr int kSteps = 12;
    const Eigen::Vector2d centre = best;
    double most = -std::numeric_limits<double>::infinity();
    for (int i = -kSteps; i <= kSteps; ++i) {
      for (int k = -kSteps; k <= kSteps; ++k) {
        const Eigen::Vector2d at =
            centre + Eigen::Vector2d(half.x() * i / kSteps, half.y() * k / kSteps);
        const double value = room_around(room, at) - 0.05 * (at - middle).norm() / (1.0 + size);
        if (value <= most) continue;
        most = value;
        best = at;
      }
    }
    half *= 0.15;
  }
  return best;
}

PlanBox box_of(const VectorPlan& plan) {
  constexpr double kMost = std::numeric_limits<double>::infinity();
  PlanBox box{.low = {kMost, kMost}, .high = {-kMost, -kMost}};
  const auto add = [&](const Eigen::Vector2d& point) {
    box.low = box.low.cwiseMin(point);
    box.high = box.high.cwiseMax(point);
  };
  for (const PlanSegment& segment : plan.segments) {
    add(segment.from);
    add(segment.to);
  }
  for (const PlanRoom& room : plan.rooms)
    for (const Eigen::Vector2d& corner : room.outline.polygon.corners) add(corner);
  return box.low.x() <= box.high.x() ? box : PlanBox{};
}

}  // namespace loopstone
