#pragma once

#include <cstdint>

namespace loopstone {

/// A small deterministic random generator: the same seed gives the same numbers with every compiler
/// and standard library (the distributions of <random> do not). Satisfies
/// UniformRandomBitGenerator. Source: Blackman and Vigna 2018, xoshiro256**, seeded by splitmix64.
class Rng {
 public:
  using result_type = std::uint64_t;

  explicit Rng(std::uint64_t seed);

  /// A generator whose numbers are independent of this one's and depend only on (seed, stream).
  [[nodiscard]] Rng fork(std::uint64_t stream) const;

  result_type operator()();
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return ~result_type{0}; }

  /// Uniform in [0, 1).
  [[nodiscard]] double uniform();
  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high);
  /// Uniform integer in [0, count). count > 0.
  [[nodiscard]] std::uint64_t below(std::uint64_t count);
  /// Normal with the given mean and standard deviation (Marsaglia's polar method).
  [[nodiscard]] double normal(double mean = 0.0, double standard_deviation = 1.0);

 private:
  std::uint64_t seed_;
  std::uint64_t state_[4];
  double spare_normal_ = 0.0;
  bool has_spare_normal_ = false;
};

}  // namespace loopstone
