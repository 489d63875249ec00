#include "slam/open_directions.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "registration/open_translation.hpp"

namespace loopstone {
namespace {

/// A patch that faces along the direction by more than this has nothing else to say.
constexpr double kMostAlong = 0.5;

/// Of each key scan; zero: all is held.
std::vector<Eigen::Vector2d> open_directions(std::span<const PlacedKey> map_T_key,
                                             const std::vector<bool>& open,
                                             const SurfacePatches& patches) {
  const std::vector<Eigen::Matrix3d> hessians = key_hessians(map_T_key, patches);
  std::vector<Eigen::Vector2d> directions(map_T_key.size(), Eigen::Vector2d::Zero());
  for (std::size_t key = 0; key < map_T_key.size(); ++key) {
    const bool is_open = (!open.empty() && open[key]) || open_translation(hessians[key]);
    if (is_open) directions[key] = weakest_direction(hessians[key]);
  }
  return directions;
}

/// The axis that directions share which may point either way: their mean at twice the angle.
class MeanAxis {
 public:
  void add(const Eigen::Vector2d& direction, double weight) {
    const double x = direction.x();
    const double y = direction.y();
    doubled_ += weight * Eigen::Vector2d(x * x - y * y, 2.0 * x * y);
  }
  [[nodiscard]] Eigen::Vector2d axis() const {
    const double angle = 0.5 * std::atan2(doubled_.y(), doubled_.x());
    return {std::cos(angle), std::sin(angle)};
  }

 private:
  Eigen::Vector2d doubled_ = Eigen::Vector2d::Zero();
};

}  // namespace

void forget_open_directions(std::span<const PlacedKey> map_T_key, const std::vector<bool>& open,
                            SurfacePatches& patches) {
  const std::vector<Eigen::Vector2d> directions = open_directions(map_T_key, open, patches);
  const auto is_open = [&](const PatchSight& sight) {
    return !directions[static_cast<std::size_t>(sight.key)].isZero();
  };
  for (SharedSurface& patch : patches.patches) {
    MeanAxis mean;
    double weight = 0.0;
    double open_weight = 0.0;
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      const PatchSight& sight = patches.sights[i];
      weight += sight.weight;
      if (!is_open(sight)) continue;
      open_weight += sight.weight;
      mean.add(directions[static_cast<std::size_t>(sight.key)], sight.weight);
    }
    if (!(open_weight > 0.0)) continue;
    const Eigen::Vector2d axis = mean.axis();
    const double along = patch.normal.dot(axis);
    if (std::abs(along) < kMostAlong && open_weight > 0.5 * weight) {
      patch.normal = (patch.normal - along * axis).normalized();
      continue;
    }
    const auto begin = patches.sights.begin() + static_cast<std::ptrdiff_t>(patch.first);
    const auto end = patches.sights.begin() + static_cast<std::ptrdiff_t>(patch.last);
    const auto kept =
        std::stable_partition(begin, end, [&](const PatchSight& s) { return !is_open(s); });
    patch.last = static_cast<std::size_t>(kept - patches.sights.begin());
  }
}

}  // namespace loopstone
