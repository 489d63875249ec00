#include "loopstone/localization/filter_health.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/localization/chi_square.hpp"

namespace loopstone {

std::string reason(const FilterHealth& health) {
  switch (health.doubt) {
    case FilterDoubt::kNone:
      break;
    case FilterDoubt::kInnovations:
      return fmt::format(
          "readings miss their predictions: chi2 per degree of freedom {:.2f}, bound {:.2f}",
          health.innovation_ratio, health.innovation_ratio_bound);
    case FilterDoubt::kEvidence:
      return fmt::format(
          "readings are improbable: log evidence {:.0f} below what is to be expected, bound {:.0f}",
          health.evidence_deficit, health.evidence_deficit_bound);
    case FilterDoubt::kEffectiveSampleSize:
      return fmt::format(
          "a reading leaves {:.2g} % of the particles: too few for the spread, or all are wrong",
          100.0 * health.effective_share);
  }
  return {};
}

FilterHealthMonitor::FilterHealthMonitor(const FilterHealthOptions& options) : options_(options) {
  if (options.window < 1 || options.min_readings < 1 || options.min_readings > options.window) {
    throw UsageError("filter health: needs 1 <= min_readings <= window");
  }
}

void FilterHealthMonitor::add(const FilterReading& reading) {
  readings_.push_back(reading);
  if (readings_.size() > static_cast<std::size_t>(options_.window)) readings_.pop_front();
}

FilterHealth FilterHealthMonitor::judge(double z_quantile) const {
  FilterHealth health;
  health.readings = static_cast<int>(readings_.size());
  if (health.readings < options_.min_readings) return health;

  double chi2 = 0.0;
  int freedom = 0;
  double shortfall = 0.0;
  double variance = 0.0;
  double jump = 0.0;
  double log_share = 0.0;
  for (const FilterReading& reading : readings_) {
    chi2 += reading.innovation_chi2;
    freedom += reading.innovation_freedom;
    shortfall += reading.expected_log_evidence - reading.log_evidence;
    variance += reading.log_evidence_variance;
    jump = std::max(jump, reading.log_evidence_jump);
    log_share += std::log(std::max(reading.effective_share, 1e-300));
  }
  if (freedom > 0) {
    health.innovation_ratio = chi2 / freedom;
    health.innovation_ratio_bound = chi_square_quantile(freedom, z_quantile) / freedom;
  }
  // exp(-t^2 / (2 (variance + jump t / 3))) = exp(-z^2 / 2), solved for t.
  const double square = z_quantile * z_quantile;
  const double linear = jump * square / 3.0;
  health.evidence_deficit = shortfall;
  health.evidence_deficit_bound =
      0.5 * (linear + std::sqrt(linear * linear + 4.0 * square * variance));
  health.effective_share = std::exp(log_share / health.readings);

  if (freedom > 0 && health.innovation_ratio > health.innovation_ratio_bound) {
    health.doubt = FilterDoubt::kInnovations;
  } else if (health.evidence_deficit > health.evidence_deficit_bound) {
    health.doubt = FilterDoubt::kEvidence;
  } else if (health.effective_share < options_.min_effective_share) {
    health.doubt = FilterDoubt::kEffectiveSampleSize;
  }
  return health;
}

}  // namespace loopstone
