#include "loopstone/base/robust_kernel.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

constexpr RobustKernel kKernels[] = {RobustKernel::kNone, RobustKernel::kHuber,
                                     RobustKernel::kCauchy, RobustKernel::kGemanMcClure,
                                     RobustKernel::kTukey};
constexpr double kChi2[] = {0.0, 1e-6, 0.1, 0.9, 1.1, 4.0, 100.0, 1e6};

TEST(RobustKernel, WeightIsTheDerivativeOfTheCost) {
  for (const RobustKernel kernel : kKernels) {
    for (const double chi2 : kChi2) {
      const double step = 1e-5 * (chi2 + 1e-3);
      const double above = evaluate(kernel, 1.3, chi2 + step).cost;
      const double below = evaluate(kernel, 1.3, chi2 - step).cost;
      const double weight = evaluate(kernel, 1.3, chi2).weight;
      EXPECT_NEAR((above - below) / (2.0 * step), weight, 1e-6 + 1e-4 * weight);
    }
  }
}

TEST(RobustKernel, WeightStaysWhenResidualAndWidthScaleTogether) {
  for (const RobustKernel kernel : kKernels) {
    for (const double chi2 : kChi2) {
      for (const double scale : {1e-3, 0.5, 7.0, 1e4}) {
        const double weight = evaluate(kernel, 1.3, chi2).weight;
        EXPECT_NEAR(evaluate(kernel, 1.3 * scale, chi2 * scale * scale).weight, weight,
                    1e-12 * weight);
      }
    }
  }
}

TEST(RobustKernel, ChangesNothingNearZeroAndNeverRaisesTheCost) {
  for (const RobustKernel kernel : kKernels) {
    EXPECT_DOUBLE_EQ(evaluate(kernel, 1.3, 0.0).weight, 1.0);
    for (const double chi2 : kChi2) {
      const RobustValue value = evaluate(kernel, 1.3, chi2);
      EXPECT_LE(value.cost, chi2);
      EXPECT_GE(value.cost, 0.0);
      EXPECT_LE(value.weight, 1.0);
      EXPECT_TRUE(value.weight > 0.0 || kernel == RobustKernel::kTukey);
      EXPECT_GE(value.weight, 0.0);
    }
  }
}

TEST(RobustKernel, HuberWeightIsWidthOverResidual) {
  EXPECT_DOUBLE_EQ(evaluate(RobustKernel::kHuber, 2.0, 16.0).weight, 0.5);
  EXPECT_DOUBLE_EQ(evaluate(RobustKernel::kHuber, 2.0, 3.9).weight, 1.0);
}

TEST(RobustKernel, TukeyForgetsWhatLiesBeyondItsWidth) {
  EXPECT_GT(evaluate(RobustKernel::kTukey, 2.0, 3.9).weight, 0.0);
  EXPECT_EQ(evaluate(RobustKernel::kTukey, 2.0, 4.1).weight, 0.0);
}

}  // namespace
}  // namespace loopstone
