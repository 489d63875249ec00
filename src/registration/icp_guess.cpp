#include "loopstone/registration/icp_guess.hpp"

#include <optional>

#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

namespace {

template <int kDimension>
std::optional<Eigen::Matrix<double, kDimension, 1>> centroid_of(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points) {
  Eigen::Matrix<double, kDimension, 1> sum = Eigen::Matrix<double, kDimension, 1>::Zero();
  std::size_t count = 0;
  for (const auto& point : points) {
    if (!is_usable_point(point)) continue;
    sum += point;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

}  // namespace

template <int kDimension>
typename RigidMotion<kDimension>::Pose initial_guess(
    IcpGuess guess, std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    std::span<const Eigen::Matrix<double, kDimension, 1>> target) {
  using Motion = RigidMotion<kDimension>;
  if (guess == IcpGuess::kIdentity) return {};
  const auto source_centroid = centroid_of<kDimension>(source);
  const auto target_centroid = centroid_of<kDimension>(target);
  if (!source_centroid || !target_centroid) return {};
  return Motion::pose(Motion::Matrix::Identity(), *target_centroid - *source_centroid);
}

template Pose2 initial_guess<2>(IcpGuess, std::span<const Eigen::Vector2d>,
                                std::span<const Eigen::Vector2d>);
template Pose3 initial_guess<3>(IcpGuess, std::span<const Eigen::Vector3d>,
                                std::span<const Eigen::Vector3d>);

}  // namespace loopstone
