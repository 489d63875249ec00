#include "loopstone/localization/injection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

/// log((1 - rate) * exp(log_average) + rate * exp(log_value)).
double blend(double log_average, double log_value, double rate) {
  const double highest = std::max(log_average, log_value);
  if (highest == -std::numeric_limits<double>::infinity()) return highest;
  return highest + std::log((1.0 - rate) * std::exp(log_average - highest) +
                            rate * std::exp(log_value - highest));
}

}  // namespace

AugmentedInjection::AugmentedInjection(double slow_rate, double fast_rate)
    : slow_rate_(slow_rate), fast_rate_(fast_rate) {
  if (!(0.0 < slow_rate && slow_rate < fast_rate && fast_rate <= 1.0)) {
    throw UsageError("augmented injection needs rates 0 < slow < fast <= 1");
  }
}

double AugmentedInjection::share_after(double log_evidence) {
  if (!(log_evidence < std::numeric_limits<double>::infinity())) {
    throw UsageError("augmented injection needs an evidence that is a number or -inf");
  }
  // -inf as a start would be an average that any reading raises without bound.
  if (!averages_) {
    if (std::isinf(log_evidence)) return 0.0;
    averages_ = LogAverages{log_evidence, log_evidence};
    return 0.0;
  }
  averages_->slow = blend(averages_->slow, log_evidence, slow_rate_);
  averages_->fast = blend(averages_->fast, log_evidence, fast_rate_);
  // Thrun 2005, table 8.3, line 13: max(0, 1 - w_fast / w_slow).
  const double share = 1.0 - std::exp(averages_->fast - averages_->slow);
  return std::clamp(share, 0.0, std::nextafter(1.0, 0.0));
}

}  // namespace loopstone
