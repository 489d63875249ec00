#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace loopstone::test {

/// A figure may be so many times what it usually is before a test fails: changes of options and
/// rounding move errors by some per cent, a mistake by more.
inline constexpr double kUsualMargin = 1.3;

/// Holds an error to what it was when last looked at. With LOOPSTONE_PRINT_FIGURES=1 in the
/// environment every measured figure is printed, so that the usual ones can be brought up to date
/// after they have become better.
[[nodiscard]] inline testing::AssertionResult as_usual(double measured, double usual) {
  if (std::getenv("LOOPSTONE_PRINT_FIGURES") != nullptr)
    std::printf("figure: measured %.6g, usual %.6g\n", measured, usual);
  if (measured <= kUsualMargin * usual) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << measured << " is more than " << kUsualMargin << " times the usual " << usual;
}

}  // namespace loopstone::test
