#include "loopstone/localization/landmark_map.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "loopstone/base/error.hpp"

namespace loopstone {

LandmarkMap::LandmarkMap(std::vector<MappedLandmark> landmarks)
    : landmarks_(std::move(landmarks)), by_x_(landmarks_.size()) {
  if (landmarks_.empty()) throw UsageError("a map of landmarks needs one at least");
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const MappedLandmark& landmark = landmarks_[i];
    const std::string name = "landmark " + std::to_string(landmark.id);
    if (!landmark.position.allFinite())
      throw UsageError("the position of " + name + " is not finite");
    if (!(landmark.sigma_m >= 0.0) || !std::isfinite(landmark.sigma_m) ||
        !(landmark.radius_m >= 0.0) || !std::isfinite(landmark.radius_m)) {
      throw UsageError("sigma and radius of " + name + " must be 0 or more");
    }
    largest_sigma_m_ = std::max(largest_sigma_m_, landmark.sigma_m);
    largest_radius_m_ = std::max(largest_radius_m_, landmark.radius_m);
    if (!index_of_id_.emplace(landmark.id, i).second) throw UsageError(name + " is given twice");
  }
  std::iota(by_x_.begin(), by_x_.end(), std::size_t{0});
  std::ranges::stable_sort(by_x_, {}, [&](std::size_t i) { return landmarks_[i].position.x(); });
}

std::optional<std::size_t> LandmarkMap::index_of(int id) const {
  const auto found = index_of_id_.find(id);
  if (found == index_of_id_.end()) return std::nullopt;
  return found->second;
}

std::vector<std::size_t> LandmarkMap::within(const Eigen::Vector2d& point, double reach_m) const {
  std::vector<std::size_t> found;
  const auto x_of = [&](std::size_t i) { return landmarks_[i].position.x(); };
  auto at = std::ranges::lower_bound(by_x_, point.x() - reach_m, {}, x_of);
  for (; at != by_x_.end() && x_of(*at) <= point.x() + reach_m; ++at) {
    if ((landmarks_[*at].position - point).norm() <= reach_m) found.push_back(*at);
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace loopstone
