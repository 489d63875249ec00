#include "loopstone/localization/beam_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localization/beam_parts.hpp"

namespace loopstone {
namespace {

/// Poses that one thread weighs in a row: enough rays to keep many under way, few enough to stay in
/// the cache.
constexpr std::size_t kChunk = 64;
/// Expected ranges are averaged over so many places of each step.
constexpr int kPlacesAStep = 4;

}  // namespace

double beam_likelihood(const BeamMixture& mixture, double max_range_m, double measured_m,
                       double expected_m) {
  if (!(measured_m >= 0.0)) return 0.0;
  return beam_parts(mixture, max_range_m, measured_m, expected_m).sum();
}

double beam_distribution(const BeamMixture& mixture, double max_range_m, double measured_m,
                         double expected_m) {
  const double z = std::clamp(measured_m, 0.0, max_range_m);
  const bool shows_nothing = expected_m > max_range_m;
  double below = mixture.random_weight * z / max_range_m;
  if (!shows_nothing) {
    const double sigma = mixture.hit_sigma_m;
    below += mixture.hit_weight *
             (normal_below((z - expected_m) / sigma) - normal_below(-expected_m / sigma)) /
             hit_share_in_range(sigma, expected_m, max_range_m);
  }
  const double room = shows_nothing ? max_range_m : expected_m;
  const double rate = mixture.short_rate_per_m;
  const double in_the_way = room <= 0.0
                                ? z / max_range_m
                                : std::expm1(-rate * std::min(z, room)) / std::expm1(-rate * room);
  return below + mixture.short_weight * in_the_way;
}

BeamModel::BeamModel(RayCaster caster, const BeamModelOptions& options)
    : caster_(std::move(caster)) {
  require_valid(options.mixture);
  const double max_range_m = caster_.max_range_m();
  const double steps = std::ceil(max_range_m / options.table_step_m);
  if (!(options.table_step_m > 0.0) || !(steps * steps <= 1e8)) {
    throw UsageError("the table of the beam model would be too large: take a larger table_step_m");
  }
  bins_ = static_cast<std::size_t>(steps);
  step_m_ = max_range_m / steps;
  per_step_ = static_cast<float>(1.0 / step_m_);

  const std::size_t row_length = bins_ + 1;
  table_.resize(row_length * row_length);
  std::vector<double> sums(row_length);
  for (std::size_t expected = 0; expected <= bins_; ++expected) {
    const bool nothing = expected == bins_;
    const int places = nothing ? 1 : kPlacesAStep;
    std::fill(sums.begin(), sums.end(), 0.0);
    for (int place = 0; place < places; ++place) {
      const double expected_m =
          nothing ? kNoBeamRange
                  : (static_cast<double>(expected) + (place + 0.5) / kPlacesAStep) * step_m_;
      double below = 0.0;
      for (std::size_t measured = 0; measured < bins_; ++measured) {
        const double end_m = static_cast<double>(measured + 1) * step_m_;
        const double below_end = beam_distribution(options.mixture, max_range_m, end_m, expected_m);
        sums[measured] += (below_end - below) / step_m_;
        below = below_end;
      }
      sums[bins_] += beam_likelihood(options.mixture, max_range_m, kNoBeamRange, expected_m);
    }
    for (std::size_t measured = 0; measured <= bins_; ++measured) {
      table_[measured * row_length + expected] =
          static_cast<float>(std::log(std::max(sums[measured], 0.0) / places));
    }
  }
}

std::size_t BeamModel::bin_of(float range_m) const {
  return static_cast<std::size_t>(
      static_cast<int>(std::clamp(range_m * per_step_, 0.0F, static_cast<float>(bins_))));
}

double BeamModel::log_likelihood(double measured_m, double expected_m) const {
  if (std::isnan(measured_m)) return 0.0;
  return static_cast<double>(table_[bin_of(static_cast<float>(measured_m)) * (bins_ + 1) +
                                    bin_of(static_cast<float>(expected_m))]);
}

void BeamModel::log_likelihoods(std::span<const Pose2> map_T_robot, const RangeBeams& beams,
                                std::span<double> out, Threads threads) const {
  if (map_T_robot.size() != out.size()) {
    throw UsageError("the beam model needs room for one likelihood a pose");
  }
  if (beams.angles_rad.size() != beams.ranges_m.size()) {
    throw UsageError("the beam model needs an angle for each range");
  }
  std::vector<double> angles_rad;
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < beams.ranges_m.size(); ++k) {
    if (std::isnan(beams.ranges_m[k])) continue;
    angles_rad.push_back(beams.angles_rad[k]);
    rows.push_back(bin_of(beams.ranges_m[k]) * (bins_ + 1));
  }
  const RangeBeams good{beams.robot_T_lidar, angles_rad, {}};
  parallel_for((out.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunk;
    const std::size_t count = std::min(kChunk, out.size() - begin);
    weigh_chunk(map_T_robot.subspan(begin, count), good, rows, out.subspan(begin, count));
  });
}

void BeamModel::weigh_chunk(std::span<const Pose2> map_T_robot, const RangeBeams& beams,
                            std::span<const std::size_t> rows, std::span<double> out) const {
  std::vector<Pose2> map_T_lidar;
  map_T_lidar.reserve(map_T_robot.size());
  for (const Pose2& pose : map_T_robot) map_T_lidar.push_back(pose * beams.robot_T_lidar);
  std::vector<float> expected_m(map_T_lidar.size() * rows.size());
  caster_.ranges(ScanRays{map_T_lidar, beams.angles_rad}, expected_m);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float* const expected = expected_m.data() + i * rows.size();
    double sum = 0.0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      sum += static_cast<double>(table_[rows[k] + bin_of(expected[k])]);
    }
    out[i] = sum;
  }
}

}  // namespace loopstone
