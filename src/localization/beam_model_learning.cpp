#include "loopstone/localization/beam_model_learning.hpp"

#include <algorithm>
#include <cmath>

#include "localization/beam_parts.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kPairsMin = 10;
constexpr double kLeastLikelihood = 1e-300;  ///< stands for a pair that no part explains
constexpr double kNegligible = 1e-12;        ///< responsibilities below are left out of sums

/// How much each part is to be thanked for each pair: the E step.
struct Responsibilities {
  std::vector<double> hit{};
  std::vector<double> in_the_way{};
  BeamParts sums{};
  double mean_log_likelihood = 0.0;
};

Responsibilities share_out(const std::vector<RangePair>& pairs, const BeamMixture& mixture,
                           double max_range_m) {
  Responsibilities result;
  result.hit.reserve(pairs.size());
  result.in_the_way.reserve(pairs.size());
  double log_likelihood = 0.0;
  for (const RangePair& pair : pairs) {
    const BeamParts parts = beam_parts(mixture, max_range_m, pair.measured_m, pair.expected_m);
    const double total = std::max(parts.sum(), kLeastLikelihood);
    log_likelihood += std::log(total);
    result.hit.push_back(parts.hit / total);
    result.in_the_way.push_back(parts.in_the_way / total);
    result.sums.hit += parts.hit / total;
    result.sums.in_the_way += parts.in_the_way / total;
    result.sums.max += parts.max / total;
    result.sums.random += parts.random / total;
  }
  result.mean_log_likelihood = log_likelihood / static_cast<double>(pairs.size());
  return result;
}

/// The expected log-likelihood of the hits as a function of sigma:
///   sum_i r_i (-log sigma - (z_i - e_i)^2 / (2 sigma^2) - log share_in_range(sigma, e_i))
class HitObjective {
 public:
  HitObjective(const std::vector<RangePair>& pairs, const Responsibilities& shares,
               double max_range_m)
      : max_range_m_(max_range_m) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double share = shares.hit[i];
      if (share < kNegligible || !is_return(pairs[i].measured_m, max_range_m)) continue;
      const double error = pairs[i].measured_m - pairs[i].expected_m;
      share_ += share;
      squares_ += share * error * error;
    }
    // Only beside the ends is the share in range not 1 in double precision.
    const double near_m = 8.5 * kWidest * closed_form();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double expected = pairs[i].expected_m;
      if (shares.hit[i] < kNegligible || !is_return(pairs[i].measured_m, max_range_m)) continue;
      if (std::min(expected, max_range_m - expected) < near_m) {
        near_ends_.push_back({expected, shares.hit[i]});
      }
    }
  }

  [[nodiscard]] double share() const { return share_; }
  /// Table 6.2, line 11: what maximises the objective without its last term.
  [[nodiscard]] double closed_form() const { return std::sqrt(squares_ / share_); }
  [[nodiscard]] double value(double sigma) const {
    double sum = -share_ * std::log(sigma) - 0.5 * squares_ / (sigma * sigma);
    for (const auto& [expected, share] : near_ends_) {
      sum -= share * std::log(hit_share_in_range(sigma, expected, max_range_m_));
    }
    return sum;
  }
  /// The last term grows with sigma, so the maximum is not below the closed form. Golden section.
  [[nodiscard]] double argmax() const {
    double low = closed_form();
    if (near_ends_.empty()) return low;
    double high = kWidest * low;
    constexpr double kGolden = 0.6180339887498949;
    for (int i = 0; i < 30; ++i) {
      const double lower = high - kGolden * (high - low);
      const double upper = low + kGolden * (high - low);
      (value(lower) >= value(upper) ? high : low) = value(lower) >= value(upper) ? upper : lower;
    }
    return 0.5 * (low + high);
  }

 private:
  struct NearEnd {
    double expected;
    double share;
  };
  static constexpr double kWidest = 3.0;
  double max_range_m_;
  double share_ = 0.0;
  double squares_ = 0.0;
  std::vector<NearEnd> near_ends_{};
};

/// The expected log-likelihood of what stands in the way as a function of the rate:
///   sum_i r_i (log rate - rate z_i - log(1 - exp(-rate room_i)))
/// It is concave: an exponential family.
class ShortObjective {
 public:
  ShortObjective(const std::vector<RangePair>& pairs, const Responsibilities& shares,
                 double max_range_m) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double room = std::min(pairs[i].expected_m, max_range_m);
      if (shares.in_the_way[i] < kNegligible || room <= 0.0) continue;
      terms_.push_back({pairs[i].measured_m, room, shares.in_the_way[i]});
    }
  }

  [[nodiscard]] bool empty() const { return terms_.empty(); }
  [[nodiscard]] double value(double rate) const {
    double sum = 0.0;
    for (const Term& term : terms_) {
      sum += term.share *
             (std::log(rate) - rate * term.measured - std::log(-std::expm1(-rate * term.room)));
    }
    return sum;
  }
  /// Newton's method on the slope, held between bounds that close in.
  [[nodiscard]] double argmax(double start, double low, double high) const {
    double rate = std::clamp(start, low, high);
    for (int i = 0; i < 30; ++i) {
      const auto [slope, curvature] = slope_at(rate);
      (slope > 0.0 ? low : high) = rate;
      double next = rate - slope / curvature;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - rate) <= 1e-9 * rate) return next;
      rate = next;
    }
    return rate;
  }

 private:
  struct Term {
    double measured;
    double room;
    double share;
  };
  struct Slope {
    double slope;
    double curvature;
  };
  /// Mean and variance of the exponential distribution cut off at the room.
  [[nodiscard]] Slope slope_at(double rate) const {
    Slope result{0.0, 0.0};
    for (const Term& term : terms_) {
      const double x = rate * term.room;
      double mean = term.room * (0.5 - x / 12.0);
      double variance = term.room * term.room / 12.0;
      if (x > 1e-3) {
        const double growth = std::expm1(x);
        mean = 1.0 / rate - term.room / growth;
        variance = std::isfinite(growth) ? 1.0 / (rate * rate) - term.room * (term.room / growth) *
                                                                     (1.0 + 1.0 / growth)
                                         : 1.0 / (rate * rate);
      }
      result.slope += term.share * (mean - term.measured);
      result.curvature -= term.share * variance;
    }
    return result;
  }

  std::vector<Term> terms_{};
};

/// The M step: each parameter only where it raises the expected likelihood.
BeamMixture improved(const std::vector<RangePair>& pairs, const Responsibilities& shares,
                     const BeamMixture& before, double max_range_m,
                     const BeamLearningOptions& options) {
  BeamMixture after = before;
  const double all = shares.sums.sum();  // less than the pairs when no part explains some
  after.hit_weight = shares.sums.hit / all;
  after.short_weight = shares.sums.in_the_way / all;
  after.max_weight = shares.sums.max / all;
  after.random_weight = shares.sums.random / all;
  const HitObjective hits(pairs, shares, max_range_m);
  if (hits.share() > kNegligible) {
    const double sigma = std::max(hits.argmax(), options.sigma_min_m);
    if (hits.value(sigma) > hits.value(before.hit_sigma_m)) after.hit_sigma_m = sigma;
  }
  const ShortObjective shorts(pairs, shares, max_range_m);
  if (!shorts.empty()) {
    const double rate = shorts.argmax(before.short_rate_per_m, options.short_rate_min_per_m,
                                      options.short_rate_max_per_m);
    if (shorts.value(rate) > shorts.value(before.short_rate_per_m)) after.short_rate_per_m = rate;
  }
  return after;
}

}  // namespace

BeamLearningResult learn_beam_mixture(std::span<const RangePair> pairs, double max_range_m,
                                      const BeamMixture& initial,
                                      const BeamLearningOptions& options) {
  require_valid(initial);
  if (!(max_range_m > 0.0 && max_range_m < kNoBeamRange)) {
    throw UsageError("learning the beam model needs a greatest range that is positive and finite");
  }
  std::vector<RangePair> usable;
  for (const RangePair& pair : pairs) {
    if (pair.measured_m >= 0.0 && pair.expected_m >= 0.0) usable.push_back(pair);
  }
  BeamLearningResult result;
  result.mixture = initial;
  result.pairs_used = static_cast<std::int64_t>(usable.size());
  if (usable.size() < kPairsMin) return result;

  result.status = BeamLearningStatus::kIterationLimit;
  Responsibilities shares = share_out(usable, result.mixture, max_range_m);
  result.mean_log_likelihood.push_back(shares.mean_log_likelihood);
  while (result.iterations < options.max_iterations) {
    const BeamMixture next = improved(usable, shares, result.mixture, max_range_m, options);
    const double before = shares.mean_log_likelihood;
    shares = share_out(usable, next, max_range_m);
    ++result.iterations;
    result.mixture = next;
    result.mean_log_likelihood.push_back(shares.mean_log_likelihood);
    if (shares.mean_log_likelihood - before < options.tolerance) {
      result.status = BeamLearningStatus::kConverged;
      break;
    }
  }
  return result;
}

std::vector<RangePair> range_pairs(const RayCaster& caster, const Pose2& map_T_robot,
                                   const RangeBeams& beams) {
  if (beams.angles_rad.size() != beams.ranges_m.size()) {
    throw UsageError("the beam model needs an angle for each range");
  }
  const Pose2 map_T_lidar = map_T_robot * beams.robot_T_lidar;
  std::vector<float> expected_m(beams.angles_rad.size());
  caster.ranges(ScanRays{{&map_T_lidar, 1}, beams.angles_rad}, expected_m);
  std::vector<RangePair> pairs;
  for (std::size_t k = 0; k < expected_m.size(); ++k) {
    pairs.push_back({static_cast<double>(beams.ranges_m[k]), static_cast<double>(expected_m[k])});
  }
  return pairs;
}

}  // namespace loopstone
