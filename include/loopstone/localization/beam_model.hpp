#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/ray_cast.hpp"

namespace loopstone {

/// What becomes of a beam: how often which of four things, and how each spreads. The weights sum to
/// 1.
struct BeamMixture {
  double hit_weight = 0.75;    ///< it returns from what the map says, with noise
  double short_weight = 0.1;   ///< something that the map does not know stands before that: people
  double max_weight = 0.05;    ///< nothing comes back although something should: glass, black cloth
  double random_weight = 0.1;  ///< anything
  double hit_sigma_m = 0.05;   ///< standard deviation of a return about what the map says
  double short_rate_per_m = 0.5;  ///< things in the way: so many a metre of beam
};

/// p(measured | expected) of one beam. Returns are densities on [0, max range) [1/m]; no return is
/// a probability: together they sum to 1. Ranges: +inf, or the greatest range and more, is no
/// return.
///
/// With z measured, e expected, R the greatest range, each part normalised on [0, R]:
///   hit     N(z; e, sigma) / (Phi((R - e) / sigma) - Phi(-e / sigma))
///   short   rate exp(-rate z) / (1 - exp(-rate e)) up to e, nothing beyond
///   max     all on "no return"
///   random  1 / R
/// Where the map shows nothing within R, a hit is "no return", and things in the way may stand
/// anywhere up to R. Where e = 0 there is no room for the short part, which is spread evenly like
/// the random one.
/// Source: Thrun, Burgard and Fox 2005, "Probabilistic Robotics", eq. 6.3 to 6.12 and table 6.1;
/// the book leaves e = 0 and e beyond R open, and makes "no return" a narrow uniform density at R.
///
/// \return the density, or for no return the probability; 0 for a measured range that is NaN or
///         negative
[[nodiscard]] double beam_likelihood(const BeamMixture& mixture, double max_range_m,
                                     double measured_m, double expected_m);

/// The probability of a return below `measured_m` (at most max_range_m): what beam_likelihood
/// integrates to.
[[nodiscard]] double beam_distribution(const BeamMixture& mixture, double max_range_m,
                                       double measured_m, double expected_m);

/// The beams of one scan, as seen from its lidar.
struct RangeBeams {
  Pose2 robot_T_lidar{};
  std::span<const double> angles_rad;  ///< counter-clockwise from the lidar's x axis
  std::span<const float> ranges_m;     ///< +inf: no return; NaN: bad, says nothing
};

struct BeamModelOptions {
  BeamMixture mixture{};
  double table_step_m = 0.05;  ///< of the tabulated likelihoods, measured and expected
};

/// How well a scan fits a map from each of many poses, beam by beam: unlike a likelihood field it
/// minds what a beam went through on its way. Likelihoods are tabulated over measured and expected
/// range, as averages over steps of the measured one, so that the table still sums to 1. Immutable
/// and thread-safe. Memory: 4 bytes a pair of steps (1.4 MB for 30 m and 5 cm), besides the
/// caster's.
/// Cost: a ray (docs/ray_casting.md) and about 2 ns a beam and pose.
class BeamModel {
 public:
  /// \param caster  on the map; its greatest range is the model's: returns from beyond count as
  ///                none
  /// Throws UsageError when a weight is negative or they don't sum to 1, or sigma, rate or step is
  /// not positive, or the table would have more than 10^8 entries.
  explicit BeamModel(RayCaster caster, const BeamModelOptions& options = {});

  /// One log-likelihood a pose [nats, densities in 1/m]: the sum over the beams, as if they were
  /// independent, which they are not, so scale it. -inf when a part without weight would be needed.
  /// Poses are dealt out in chunks of a fixed size: the same bytes for any number of threads.
  /// Throws UsageError where the sizes of poses and out, or of angles and ranges, differ.
  void log_likelihoods(std::span<const Pose2> map_T_robot, const RangeBeams& beams,
                       std::span<double> out, Threads threads = {1}) const;

  /// The table's entry for one beam; 0 for NaN.
  [[nodiscard]] double log_likelihood(double measured_m, double expected_m) const;

  [[nodiscard]] const RayCaster& caster() const { return caster_; }
  [[nodiscard]] double table_step_m() const { return step_m_; }
  /// Of the table, without the caster.
  [[nodiscard]] std::size_t memory_bytes() const { return table_.size() * sizeof(float); }

 private:
  [[nodiscard]] std::size_t bin_of(float range_m) const;
  void weigh_chunk(std::span<const Pose2> map_T_robot, const RangeBeams& beams,
                   std::span<const std::size_t> rows, std::span<double> out) const;

  RayCaster caster_;
  double step_m_ = 0.0;
  float per_step_ = 0.0F;
  std::size_t bins_ = 0;  ///< of finite ranges; one more stands for none
  std::vector<float>
      table_{};  ///< a row a measured range, so a beam reads from one row for all poses
};

}  // namespace loopstone
