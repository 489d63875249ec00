#include "loopstone/slam/submap_record.hpp"

#include <cmath>
#include <utility>

namespace loopstone {

void SubmapRecord::freeze(FinishedSubmap submap) {
  state = SubmapState::kFrozen;
  piece = submap.piece;
  frozen = std::make_shared<const FrozenSubmap>(std::move(submap.submap));
  const auto& surfaces = frozen->surfaces;
  if (surfaces.empty()) return;
  for (const auto& surface : surfaces) centre += surface.position.cast<double>();
  centre /= static_cast<double>(surfaces.size());
  double sum = 0.0;
  for (const auto& surface : surfaces)
    sum += (surface.position.cast<double>() - centre).squaredNorm();
  radius_m = std::sqrt(sum / static_cast<double>(surfaces.size()));
}

void SubmapRecord::drop() {
  state = SubmapState::kDropped;
  frozen = nullptr;
  descriptor = {};
}

std::vector<Pose2> poses_of(std::span<const SubmapRecord> submaps) {
  std::vector<Pose2> poses;
  poses.reserve(submaps.size());
  for (const SubmapRecord& submap : submaps) poses.push_back(submap.map_T_submap);
  return poses;
}

}  // namespace loopstone
