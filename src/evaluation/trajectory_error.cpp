#include "loopstone/evaluation/trajectory_error.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

/// Poses of both trajectories at the same stamps, and the way along the reference up to each.
struct Pairs {
  std::vector<Stamp> stamps;
  std::vector<Pose2> estimate;
  std::vector<Pose2> reference;
  std::vector<double> path_m;
  std::int64_t missing = 0;
};

Pairs pair_up(const Trajectory& estimate, const Trajectory& reference) {
  Pairs pairs;
  double path_m = 0.0;
  const StampedPose2* before = nullptr;
  for (const StampedPose2& pose : reference.poses()) {
    if (before != nullptr) {
      path_m += (pose.pose.translation() - before->pose.translation()).norm();
    }
    before = &pose;
    if (const auto estimated = estimate.at(pose.stamp)) {
      pairs.stamps.push_back(pose.stamp);
      pairs.estimate.push_back(*estimated);
      pairs.reference.push_back(pose.pose);
      pairs.path_m.push_back(path_m);
    } else {
      ++pairs.missing;
    }
  }
  return pairs;
}

bool far_enough(const Pairs& pairs, std::size_t i, std::size_t j, double delta, Spacing spacing) {
  switch (spacing) {
    case Spacing::kFrames:
      return static_cast<double>(j - i) >= delta;
    case Spacing::kMetres:
      return pairs.path_m[j] - pairs.path_m[i] >= delta;
    case Spacing::kSeconds:
      break;
  }
  return pairs.stamps[j] - pairs.stamps[i] >= Duration::from_seconds(delta);
}

}  // namespace

ErrorStatistics statistics_of(std::vector<double> errors) {
  if (errors.empty()) return {};
  const auto count = static_cast<double>(errors.size());
  ErrorStatistics result;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double error : errors) {
    sum += error;
    sum_of_squares += error * error;
  }
  result.mean = sum / count;
  result.rmse = std::sqrt(sum_of_squares / count);
  double spread = 0.0;  // in a second pass: sum_of_squares - count * mean^2 loses all digits
  for (const double error : errors) spread += (error - result.mean) * (error - result.mean);
  if (errors.size() > 1) result.std = std::sqrt(spread / (count - 1.0));
  std::sort(errors.begin(), errors.end());
  result.max = errors.back();
  const std::size_t middle = errors.size() / 2;
  result.median =
      errors.size() % 2 == 1 ? errors[middle] : 0.5 * (errors[middle - 1] + errors[middle]);
  return result;
}

Pose2 align_trajectories(const std::vector<Pose2>& estimate, const std::vector<Pose2>& reference) {
  assert(estimate.size() == reference.size());
  if (estimate.empty()) return {};
  Eigen::Vector2d estimate_centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d reference_centre = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate_centre += estimate[i].translation();
    reference_centre += reference[i].translation();
  }
  estimate_centre /= static_cast<double>(estimate.size());
  reference_centre /= static_cast<double>(reference.size());

  // The rotation R maximises sum r_i . R e_i = cos(yaw) sum e_i . r_i + sin(yaw) sum e_i x r_i.
  double along = 0.0;
  double across = 0.0;
  double spread = 0.0;
  double heading_cosine = 0.0;
  double heading_sine = 0.0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Eigen::Vector2d e = estimate[i].translation() - estimate_centre;
    const Eigen::Vector2d r = reference[i].translation() - reference_centre;
    along += e.dot(r);
    across += e.x() * r.y() - e.y() * r.x();
    spread += e.squaredNorm() + r.squaredNorm();
    heading_cosine += std::cos(reference[i].yaw - estimate[i].yaw);
    heading_sine += std::sin(reference[i].yaw - estimate[i].yaw);
  }
  const bool points_tell = hypotenuse(along, across) > 1e-9 * spread && spread > 1e-12;
  const double yaw =
      points_tell ? std::atan2(across, along) : std::atan2(heading_sine, heading_cosine);
  const Eigen::Vector2d translation =
      reference_centre - Pose2{0.0, 0.0, yaw}.rotation() * estimate_centre;
  return {translation.x(), translation.y(), wrap_angle(yaw)};
}

AbsoluteError absolute_error(const Trajectory& estimate, const Trajectory& reference,
                             Alignment alignment) {
  const Pairs pairs = pair_up(estimate, reference);
  AbsoluteError result;
  result.poses = static_cast<std::int64_t>(pairs.stamps.size());
  result.poses_missing = pairs.missing;
  if (alignment == Alignment::kSe2) {
    result.reference_T_estimate = align_trajectories(pairs.estimate, pairs.reference);
  }
  PoseErrors& errors = result.by_pose;
  for (std::size_t i = 0; i < pairs.stamps.size(); ++i) {
    const Pose2 aligned = result.reference_T_estimate * pairs.estimate[i];
    errors.stamps.push_back(pairs.stamps[i]);
    errors.translation_m.push_back(
        (aligned.translation() - pairs.reference[i].translation()).norm());
    errors.rotation_rad.push_back(std::abs(wrap_angle(aligned.yaw - pairs.reference[i].yaw)));
  }
  result.translation_m = statistics_of(errors.translation_m);
  result.rotation_rad = statistics_of(errors.rotation_rad);
  return result;
}

RelativeError relative_error(const Trajectory& estimate, const Trajectory& reference, double delta,
                             Spacing spacing) {
  const Pairs pairs = pair_up(estimate, reference);
  RelativeError result;
  PoseErrors& errors = result.by_pair;
  std::size_t j = 0;
  for (std::size_t i = 0; i < pairs.stamps.size(); ++i) {
    j = std::max(j, i + 1);  // a pair is two different poses, however small delta is
    while (j < pairs.stamps.size() && !far_enough(pairs, i, j, delta, spacing)) ++j;
    if (j >= pairs.stamps.size()) break;
    const Pose2 expected = pairs.reference[i].inverse() * pairs.reference[j];
    const Pose2 measured = pairs.estimate[i].inverse() * pairs.estimate[j];
    const Pose2 error = expected.inverse() * measured;
    errors.stamps.push_back(pairs.stamps[i]);
    errors.translation_m.push_back(error.translation().norm());
    errors.rotation_rad.push_back(std::abs(error.yaw));
  }
  result.pairs = static_cast<std::int64_t>(errors.stamps.size());
  result.translation_m = statistics_of(errors.translation_m);
  result.rotation_rad = statistics_of(errors.rotation_rad);
  return result;
}

}  // namespace loopstone
