#include "localization/observation_window.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace loopstone {
namespace {

/// What is less certain than this tells no constellation [m].
constexpr double kWorstSigmaM = 0.5;
/// Pairs grow with the square.
constexpr std::size_t kMost = 16;
/// Squared Mahalanobis distance within which two that look alike are one; 99.9 % of two.
constexpr double kSameChi2 = 13.8;

bool is_same(const LandmarkObservation& a, const LandmarkObservation& b) {
  if (a.id || b.id) return a.id == b.id;
  const Eigen::Vector2d off = a.point - b.point;
  const Eigen::Matrix2d spread = a.covariance + b.covariance;
  return off.dot(spread.inverse() * off) < kSameChi2;
}

}  // namespace

// p_to = R^T (p_from - t):  dp/dt = -R^T,  dp/dyaw = (p_y, -p_x).
void ObservationWindow::move(const PoseWithCovariance2& motion) {
  const Eigen::Matrix2d to_R_from = motion.pose.rotation().transpose();
  for (LandmarkObservation& seen : observations_) {
    seen.point = to_R_from * (seen.point - motion.pose.translation());
    seen.direction = to_R_from * seen.direction;
    Eigen::Matrix<double, 2, 3> by_motion;
    by_motion.leftCols<2>() = -to_R_from;
    by_motion.col(2) << seen.point.y(), -seen.point.x();
    seen.covariance = to_R_from * seen.covariance * to_R_from.transpose() +
                      by_motion * motion.covariance * by_motion.transpose();
  }
  std::erase_if(observations_, [](const LandmarkObservation& seen) {
    return seen.covariance.trace() > 2.0 * kWorstSigmaM * kWorstSigmaM;
  });
}

void ObservationWindow::add(const std::vector<LandmarkObservation>& observations) {
  std::erase_if(observations_, [&](const LandmarkObservation& old) {
    return std::ranges::any_of(observations,
                               [&](const LandmarkObservation& seen) { return is_same(old, seen); });
  });
  observations_.insert(observations_.end(), observations.begin(), observations.end());
  if (observations_.size() <= kMost) return;
  observations_.erase(observations_.begin(),
                      observations_.end() - static_cast<std::ptrdiff_t>(kMost));
}

}  // namespace loopstone
