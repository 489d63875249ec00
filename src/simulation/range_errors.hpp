#pragma once

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism.hpp"

namespace loopstone {

/// Bias, scale and noise of ranges, by range and incidence.
class RangeErrors {
 public:
  RangeErrors(const RealismRange& options, Rng rng);

  /// What the laser says of a range; draws for every beam, whatever it meets.
  [[nodiscard]] double measured(double range_m, double tan_incidence);
  /// Standard deviation that it adds.
  [[nodiscard]] double spread_m(double range_m, double tan_incidence) const;
  void note(RealismRecord& record) const;

 private:
  RealismRange options_;
  Rng rng_;
  double bias_m_;
  double scale_;
};

}  // namespace loopstone
