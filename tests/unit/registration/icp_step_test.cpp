#include "registration/icp_step.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

template <int kDimension>
using Motion = RigidMotion<kDimension>;

template <int kDimension>
typename Motion<kDimension>::Vector random_vector(Rng& rng, double size) {
  typename Motion<kDimension>::Vector v;
  for (int k = 0; k < kDimension; ++k) v(k) = rng.uniform(-size, size);
  return v;
}

/// Pairs at a pose; only what the equations read is filled in.
template <int kDimension>
std::vector<IcpPair<kDimension>> random_pairs(const typename Motion<kDimension>::Pose& pose,
                                              int count, Rng& rng) {
  std::vector<IcpPair<kDimension>> pairs(static_cast<std::size_t>(count));
  for (auto& pair : pairs) {
    pair.source = random_vector<kDimension>(rng, 5.0);
    pair.arm = Motion<kDimension>::rotation(pose) * pair.source;
    pair.offset = random_vector<kDimension>(rng, 0.2);
    pair.normal = random_vector<kDimension>(rng, 1.0).normalized();
    pair.turned_normal = random_vector<kDimension>(rng, 1.0).normalized();
    pair.weight = rng.uniform(0.0, 1.0);
  }
  return pairs;
}

/// By the definition: the covariances are written out and inverted.
template <int kDimension>
Eigen::Matrix<double, kDimension, kDimension> gicp_matrix(const IcpPair<kDimension>& pair) {
  using Matrix = Eigen::Matrix<double, kDimension, kDimension>;
  constexpr double kAcross = 1e-3;
  const auto covariance = [](const auto& normal) -> Matrix {
    return Matrix::Identity() - (1.0 - kAcross) * normal * normal.transpose();
  };
  return 2.0 * kAcross * (covariance(pair.normal) + covariance(pair.turned_normal)).inverse();
}

/// Half of the cost when frame b has made a small motion, pairs and weights held.
template <int kDimension>
double half_cost(const std::vector<IcpPair<kDimension>>& pairs, IcpMetric metric,
                 const typename Motion<kDimension>::Pose& pose,
                 const typename Motion<kDimension>::Tangent& motion) {
  const auto moved = Motion<kDimension>::moved(pose, motion);
  double cost = 0.0;
  for (const auto& pair : pairs) {
    const typename Motion<kDimension>::Vector shift = moved * pair.source - pose * pair.source;
    const typename Motion<kDimension>::Vector offset = pair.offset + shift;
    double squared = offset.squaredNorm();
    if (metric == IcpMetric::kGicp) {
      squared = offset.dot(gicp_matrix<kDimension>(pair) * offset);
    } else if (metric != IcpMetric::kPoint) {
      squared = std::pow(pair.normal.dot(offset), 2);
    }
    cost += 0.5 * pair.weight * squared;
  }
  return cost;
}

template <int kDimension>
void expect_numeric_derivatives(const typename Motion<kDimension>::Pose& pose, Rng& rng) {
  constexpr int kDof = Motion<kDimension>::kDof;
  constexpr double kStep = 1e-5;
  using Tangent = typename Motion<kDimension>::Tangent;
  for (const IcpMetric metric :
       {IcpMetric::kPoint, IcpMetric::kLine, IcpMetric::kPlane, IcpMetric::kGicp}) {
    auto pairs = random_pairs<kDimension>(pose, 40, rng);
    const auto gradient_at = [&] {
      Tangent gradient;
      for (int i = 0; i < kDof; ++i) {
        const Tangent step = kStep * Tangent::Unit(i);
        gradient(i) = (half_cost<kDimension>(pairs, metric, pose, step) -
                       half_cost<kDimension>(pairs, metric, pose, -step)) /
                      (2.0 * kStep);
      }
      return gradient;
    };
    const auto equations = equations_of<kDimension>(pairs, metric);
    EXPECT_LT((equations.gradient - gradient_at()).norm(), 1e-6 * equations.gradient.norm());

    // Without residuals the Gauss-Newton matrix is the second derivative.
    for (auto& pair : pairs) pair.offset.setZero();
    const double unmoved = half_cost<kDimension>(pairs, metric, pose, Tangent::Zero());
    const auto along = [&](const Tangent& direction) {
      const Tangent step = 1e-4 * direction;
      return (half_cost<kDimension>(pairs, metric, pose, step) +
              half_cost<kDimension>(pairs, metric, pose, -step) - 2.0 * unmoved) /
             1e-8;
    };
    for (int draw = 0; draw < 10; ++draw) {
      Tangent direction;
      for (int i = 0; i < kDof; ++i) direction(i) = rng.uniform(-1.0, 1.0);
      const double expected = direction.dot(equations.information * direction);
      EXPECT_NEAR(along(direction), expected, 1e-5 * expected);
    }
  }
}

TEST(IcpStep, AnalyticDerivativesAreTheNumericOnes) {
  Rng rng(61);
  for (int draw = 0; draw < 5; ++draw) {
    expect_numeric_derivatives<2>(
        {rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)}, rng);
    Tangent3 twist;
    for (int i = 0; i < 6; ++i) twist(i) = rng.uniform(-2.0, 2.0);
    expect_numeric_derivatives<3>(exp(twist), rng);
  }
}

TEST(IcpStep, GicpWeightIsTheInverseOfTheSummedCovariances) {
  Rng rng(62);
  for (int draw = 0; draw < 100; ++draw) {
    auto pair = random_pairs<3>(Pose3{}, 1, rng).front();
    if (draw % 4 == 1) pair.normal.setZero();  // no surface
    if (draw % 4 == 2) pair.turned_normal = pair.normal;
    if (draw % 4 == 3) pair.turned_normal = -pair.normal;
    const Eigen::Vector3d& n = pair.normal;
    const Eigen::Vector3d& m = pair.turned_normal;
    const GicpWeight weight(n.dot(m));
    const Eigen::Matrix3d matrix =
        weight.scale *
        (Eigen::Matrix3d::Identity() + weight.same * (n * n.transpose() + m * m.transpose()) +
         weight.cross * (n * m.transpose() + m * n.transpose()));
    EXPECT_TRUE(matrix.isApprox(gicp_matrix<3>(pair), 1e-9));
    // Across two parallel surfaces it counts metres.
    if (draw % 4 > 1) {
      EXPECT_NEAR(n.dot(matrix * n), 1.0, 1e-9);
    }
  }
}

TEST(IcpStep, WeightsStayWhenResidualsAndWidthScaleTogether) {
  Rng rng(63);
  for (const auto& [kernel, name] : kWordTable<RobustKernel>) {
    for (const double scale : {1e-3, 7.0, 1e4}) {
      auto pairs = random_pairs<2>({}, 50, rng);
      for (auto& pair : pairs) {
        pair.squared_distance_m2 = pair.offset.squaredNorm();
        pair.squared_residual_m2 = std::pow(pair.normal.dot(pair.offset), 2);
      }
      auto scaled = pairs;
      for (auto& pair : scaled) {
        pair.squared_distance_m2 *= scale * scale;
        pair.squared_residual_m2 *= scale * scale;
      }
      const double cost = weigh<2>(pairs, 0.8, kernel, 0.05);
      const double scaled_cost = weigh<2>(scaled, 0.8, kernel, 0.05 * scale);
      EXPECT_NEAR(scaled_cost, scale * scale * cost, 1e-9 * scaled_cost) << name;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        EXPECT_NEAR(scaled[i].weight, pairs[i].weight, 1e-12) << name;
      }
    }
  }
}

TEST(IcpStep, TrimmingLeavesOutTheFarthestPairs) {
  Rng rng(64);
  auto pairs = random_pairs<3>(Pose3{}, 100, rng);
  for (auto& pair : pairs) pair.squared_distance_m2 = pair.offset.squaredNorm();
  (void)weigh<3>(pairs, 0.7, RobustKernel::kNone, 0.1);
  double farthest_kept = 0.0;
  double nearest_left_out = 1e9;
  int kept = 0;
  for (const auto& pair : pairs) {
    if (pair.weight > 0.0) {
      farthest_kept = std::max(farthest_kept, pair.squared_distance_m2);
      ++kept;
    } else {
      nearest_left_out = std::min(nearest_left_out, pair.squared_distance_m2);
    }
  }
  EXPECT_EQ(kept, 70);
  EXPECT_LE(farthest_kept, nearest_left_out);
}

}  // namespace
}  // namespace loopstone
