#include "loopstone/evaluation/relations.hpp"

#include <cmath>
#include <optional>

namespace loopstone {

namespace {

constexpr Duration kSameStamp{100'000};

struct FoundPose {
  Pose2 pose;
  bool interpolated;
};

std::optional<FoundPose> find_pose(const Trajectory& trajectory, Stamp stamp) {
  if (const auto exact = trajectory.nearest(stamp, kSameStamp)) return FoundPose{*exact, false};
  if (const auto between = trajectory.at(stamp)) return FoundPose{*between, true};
  return {};
}

}  // namespace

RelationsError relations_error(const Trajectory& estimate, const std::vector<Relation>& relations,
                               RelationErrorOrder order) {
  RelationsError result;
  std::vector<double> translation_m;
  std::vector<double> squared_translation_m2;
  std::vector<double> rotation_rad;
  std::vector<double> squared_rotation_deg2;
  for (const Relation& relation : relations) {
    const auto from = find_pose(estimate, relation.from);
    const auto to = find_pose(estimate, relation.to);
    if (!from || !to) {
      result.missing.push_back(relation);
      continue;
    }
    if (from->interpolated || to->interpolated) ++result.pairs_interpolated;
    const Pose2 measured = from->pose.inverse() * to->pose;
    const Pose2 error = order == RelationErrorOrder::kMeasuredTimesInverseExpected
                            ? measured * relation.from_T_to.inverse()
                            : relation.from_T_to.inverse() * measured;
    translation_m.push_back(error.translation().norm());
    squared_translation_m2.push_back(error.translation().squaredNorm());
    rotation_rad.push_back(std::abs(error.yaw));
    squared_rotation_deg2.push_back(degrees(error.yaw) * degrees(error.yaw));
  }
  result.pairs = static_cast<std::int64_t>(translation_m.size());
  result.translation_m = statistics_of(std::move(translation_m));
  result.squared_translation_m2 = statistics_of(std::move(squared_translation_m2));
  result.rotation_rad = statistics_of(std::move(rotation_rad));
  result.squared_rotation_deg2 = statistics_of(std::move(squared_rotation_deg2));
  return result;
}

}  // namespace loopstone
