#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"

// What weighing particles by a likelihood field is measured against: the update of beluga's
// LikelihoodFieldModel (Ekumen, https://github.com/Ekumen-OS/beluga), written anew. Not beluga
// itself: that needs range-v3, Sophus and more that Debian does not package. What is done for each
// particle is the same: a state that holds its sine and cosine in doubles, points as pairs of
// doubles, cells found by Eigen's floor, one float a cell, a check against the map's edges, the sum
// of cubes by std::transform_reduce. Its ranges and optionals are left out; they would not make it
// faster.
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
    const double peak = kHit / (kSigma_m * std::sqrt(2.0 * kPi));
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
          const Eigen::Vector2i near =
              (Eigen::Vector2d(x, y) * (1.0 / frame_.resolution)).array().floor().cast<int>();
          const Cell cell{near.x(), near.y()};
          const double likelihood = frame_.contains(cell)
                                        ? static_cast<double>(likelihoods_[frame_.index_of(cell)])
                                        : 1.0 / kMaxRange_m;
          return likelihood * likelihood * likelihood;
        });
  }

  GridFrame frame_;
  std::vector<float> likelihoods_;
};

}  // namespace loopstone::bench
