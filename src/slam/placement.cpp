#include "slam/placement.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/angle.hpp"
#include "slam/loop_verification.hpp"
#include "slam/pairwise_consistency.hpp"

namespace loopstone {

bool is_elsewhere(const Pose2& pose, const Pose2& found, double share) {
  return (pose.translation() - found.translation()).norm() >=
             share * kLoopVerification.elsewhere_m ||
         std::abs(wrap_angle(pose.yaw - found.yaw)) >= share * kLoopVerification.elsewhere_rad;
}

Pose2 laid_by(const LoopClosure& closure, SubmapId newer, std::span<const SubmapRecord> submaps) {
  return map_move_of(closure, submaps) * submaps[newer.index].map_T_submap;
}

bool Placement::concerns(const LoopClosure& closure) const {
  const auto piece = [&](SubmapId submap) { return submaps_[submap.index].piece; };
  const LoopClosure& own = asked_.front()->closure;
  return piece(closure.from_submap) == piece(own.from_submap) &&
         piece(closure.to_submap) == piece(own.to_submap);
}

bool Placement::holds(const LoopClosure& closure) const {
  const SubmapId newer = closure.to_submap;
  const Pose2 at_centre = Pose2{submaps_[newer.index].centre.x(), submaps_[newer.index].centre.y()};
  return !is_elsewhere(laid_by(closure, newer, submaps_) * at_centre,
                       map_T_submap(newer) * at_centre);
}

const AskedClosure& Placement::nearest(SubmapId newer) const {
  const auto apart = [&](const AskedClosure* asked) {
    const std::size_t other = asked->closure.to_submap.index;
    return std::max(other, newer.index) - std::min(other, newer.index);
  };
  return **std::ranges::min_element(asked_, {}, apart);
}

Pose2 Placement::map_T_submap(SubmapId newer) const {
  return laid_by(nearest(newer).closure, newer, submaps_);
}

std::vector<SubmapId> Placement::witnesses() const {
  const auto newer = [](const AskedClosure* asked) { return asked->closure.to_submap.index; };
  const auto [first, last] = std::ranges::minmax(asked_, {}, newer);
  const std::size_t begin = newer(first) - std::min(newer(first), kPlacement.around);
  const std::size_t end = std::min(newer(last) + kPlacement.around + 1, submaps_.size());
  std::vector<SubmapId> found;
  for (std::size_t i = begin; i < end; ++i) {
    if (submaps_[i].piece == submaps_[newer(first)].piece && submaps_[i].surface_count() > 0)
      found.push_back({i});
  }
  return thinned(found, kPlacement.witnesses);
}

}  // namespace loopstone
