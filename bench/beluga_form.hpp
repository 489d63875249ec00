#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"

// What the update of a particle filter by a likelihood field is measured against: beluga's LikelihoodFieldModel
// (Ekumen, https://github.com/Ekumen-OS/beluga), written anew from its description. Not beluga itself: that needs range-v3, Sophus
// and more that Debian does not package. What it does for each particle is the same: states with sine and cosine in
// doubles already there, points as pairs of doubles, one likelihood a cell, a check against the map's edges, the sum of cubes by
// std::transform_reduce. Without its lock and its ranges, and the particles' weights are written straight.
namespace loopstone::bench {

class BelugaForm {
 public:
  /// A Sophus::SE2d.
  struct State {
    double cos = 1.0;
    double sin = 0.0;
    double x = 0.0;
    double y = 0.0;
  };
  using Points = std::vector<std::pair<double, double>>;

  explicit BelugaForm(const Grid<float>& distances_m)
      : frame_(distances_m.frame()), likelihoods_(distances_m.cells().size()) {
    const double peak = kHit / (kSigma_m * std::sqrt(2.0 * 3.14159265358979323846));
    for (std::size_t i = 0; i < likelihoods_.size(); ++i) {
      const double d = std::min(static_cast<double>(distances_m.cells()[i]), kMaxDistance_m);
      likelihoods_[i] = static_cast<float>(peak * std::exp(-d * d / (2.0 * kSigma_m * kSigma_m)) +
                                           kRandom / kMaxRange_m);
    }
  }

  [[nodiscard]] static State state_of(const Pose2& map_T_robot) {
    return {std::cos(map_T_robot.yaw), std::sin(map_T_robot.yaw), map_T_robot.x, map_T_robot.y};
  }

  void reweight(const std::vector<State>& states, const Points& points,
                std::vector<double>& weights) const {
    for (std::size_t i = 0; i < states.size(); ++i) weights[i] *= weight(states[i], points);
  }

 private:
  static constexpr double kHit = 0.5;
  static constexpr double kRandom = 0.5;
  static constexpr double kSigma_m = 0.2;
  static constexpr double kMaxDistance_m = 2.0;
  static constexpr double kMaxRange_m = 100.0;

  [[nodiscard]] double weight(const State& state, const Points& points) const {
    const double x_offset = state.x - frame_.origin.x();
    const double y_offset = state.y - frame_.origin.y();
    return std::transform_reduce(
        points.begin(), points.end(), 1.0, std::plus<>(), [=, this](const auto& point) {
          const double x = point.first * state.cos - point.second * state.sin + x_offset;
          const double y = point.first * state.sin + point.second * state.cos + y_offset;
          const auto column = static_cast<int>(std::floor(x / frame_.resolution));
          const auto row = static_cast<int>(std::floor(y / frame_.resolution));
          const double likelihood =
              frame_.contains({column, row})
                  ? static_cast<double>(likelihoods_[frame_.index_of({column, row})])
                  : 1.0 / kMaxRange_m;
          return likelihood * likelihood * likelihood;
        });
  }

  GridFrame frame_;
  std::vector<float> likelihoods_;
};

}  // namespace loopstone::bench
