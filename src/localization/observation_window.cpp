#include "localization/observation_window.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

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

/// Things of a reading that were seen before and are seen again.
constexpr double kSeenAgain = 0.9;

double log_density(const LandmarkObservation& old, const LandmarkObservation& seen) {
  const Eigen::Vector2d off = seen.point - old.point;
  const Eigen::Matrix2d spread = old.covariance + seen.covariance;
  return -0.5 * (off.dot(spread.inverse() * off) + std::log(spread.determinant())) -
         std::log(2.0 * kPi);
}

}  // namespace

std::vector<BlindExpectation> ObservationWindow::expectations(
    const std::vector<LandmarkObservation>& reading, double log_anywhere) const {
  std::vector<BlindExpectation> expected;
  for (const LandmarkObservation& seen : reading) {
    BlindExpectation expectation{.log_density = log_anywhere};
    for (const LandmarkObservation& old : observations_) {
      if (!is_same(old, seen)) continue;
      const double again = std::log(kSeenAgain) + log_density(old, seen);
      if (again <= expectation.log_density) continue;
      expectation = {.log_density = again, .is_seen_before = true};
    }
    expected.push_back(expectation);
  }
  return expected;
}

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
