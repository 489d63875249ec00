#include "loopstone/localization/filter_health.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/localization/chi_square.hpp"

namespace loopstone {
namespace {

/// A reading of two numbers as a right filter sees it, worsened.
FilterReading reading(Rng& rng, double noise_scale, double missing_evidence) {
  FilterReading result;
  for (int i = 0; i < 2; ++i) result.innovation_chi2 += std::pow(rng.normal(0.0, noise_scale), 2);
  result.innovation_freedom = 2;
  result.expected_log_evidence = -4.0;
  result.log_evidence = -4.0 + rng.normal() - missing_evidence;
  result.log_evidence_variance = 1.0;
  result.effective_share = 0.4;
  return result;
}

FilterHealth health_after(int readings, double noise_scale, double missing_evidence,
                          double share = 0.4) {
  Rng rng(2);
  FilterHealthMonitor monitor;
  for (int i = 0; i < readings; ++i) {
    FilterReading next = reading(rng, noise_scale, missing_evidence);
    next.effective_share = share;
    monitor.add(next);
  }
  return monitor.judge();
}

TEST(FilterHealth, BelievesGoodReadings) {
  Rng rng(1);
  FilterHealthMonitor monitor;
  for (int i = 0; i < 20000; ++i) {
    monitor.add(reading(rng, 1.0, 0.0));
    ASSERT_EQ(monitor.judge().doubt, FilterDoubt::kNone) << "reading " << i;
  }
  EXPECT_EQ(reason(monitor.judge()), "");
}

TEST(FilterHealth, NamesWhatIsWrong) {
  EXPECT_EQ(health_after(20, 2.0, 0.0).doubt, FilterDoubt::kInnovations);
  EXPECT_EQ(health_after(20, 1.0, 2.0).doubt, FilterDoubt::kEvidence);
  EXPECT_EQ(health_after(20, 1.0, 0.0, 0.002).doubt, FilterDoubt::kEffectiveSampleSize);
  EXPECT_NE(reason(health_after(20, 2.0, 0.0)).find("chi2"), std::string::npos);
  EXPECT_NE(reason(health_after(20, 1.0, 2.0)).find("improbable"), std::string::npos);
  EXPECT_NE(reason(health_after(20, 1.0, 0.0, 0.002)).find("0.2 %"), std::string::npos);
  EXPECT_EQ(to_string(FilterDoubt::kEvidence), "evidence");
  EXPECT_EQ(to_string(FilterStatus::kInconsistent), "inconsistent");
}

TEST(FilterHealth, DoesNotJudgeTooEarlyAndForgets) {
  EXPECT_EQ(health_after(4, 20.0, 100.0).doubt, FilterDoubt::kNone);
  Rng rng(3);
  FilterHealthMonitor monitor;
  for (int i = 0; i < 20; ++i) monitor.add(reading(rng, 5.0, 0.0));
  EXPECT_NE(monitor.judge().doubt, FilterDoubt::kNone);
  for (int i = 0; i < 20; ++i) monitor.add(reading(rng, 1.0, 0.0));
  EXPECT_EQ(monitor.judge().doubt, FilterDoubt::kNone);
  monitor.reset();
  EXPECT_EQ(monitor.judge().readings, 0);
  EXPECT_THROW(FilterHealthMonitor({.window = 3, .min_readings = 4}), UsageError);
}

// Values of a table of the chi-square distribution.
TEST(ChiSquareQuantile, AgreesWithTheTable) {
  EXPECT_NEAR(chi_square_quantile(3, 2.3263), 11.345, 0.1);
  EXPECT_NEAR(chi_square_quantile(10, 1.6449), 18.307, 0.05);
  EXPECT_NEAR(chi_square_quantile(40, 3.0902), 73.402, 0.2);
  EXPECT_NEAR(chi_square_quantile(100, 0.0), 99.334, 0.05);
  EXPECT_EQ(chi_square_quantile(0, 3.0), 0.0);
}

}  // namespace
}  // namespace loopstone
