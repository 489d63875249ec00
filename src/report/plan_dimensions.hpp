#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/plan/vector_plan.hpp"

namespace loopstone {

/// From wall to wall, straight across a room.
struct RoomSpan {
  Eigen::Vector2d from{0.0, 0.0};
  Eigen::Vector2d to{0.0, 0.0};
  [[nodiscard]] double length_m() const { return (to - from).norm(); }
};

/// The width and the depth of a room along the plan's first axis, where they are at their greatest
/// and out of the way of the room's name. None of a room that is not all seen.
[[nodiscard]] std::vector<RoomSpan> room_spans(const PlanRoom& room, const VectorPlan& plan);

}  // namespace loopstone
