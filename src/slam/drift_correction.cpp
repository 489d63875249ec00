#include "slam/drift_correction.hpp"

#include <algorithm>
#include <utility>

namespace loopstone {

DriftCorrection::DriftCorrection(std::vector<KeyScan> keys, std::span<const Pose2> map_T_key,
                                 std::span<const PathBreak> breaks)
    : keys_(std::move(keys)) {
  map_T_local_.reserve(keys_.size());
  changes_.reserve(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const KeyScan& key = keys_[i];
    map_T_local_.push_back(map_T_key[i] * key.local_T_robot.inverse());
    changes_.push_back({keys_[i > 0 ? i - 1 : 0].stamp, key.stamp});
    if (!key.across) continue;
    for (const PathBreak& gap : breaks) {
      if (gap.from < gap.to && gap.from >= changes_.back().from && gap.to <= key.stamp)
        changes_.back() = {gap.from, gap.to};
    }
  }
}

Pose2 DriftCorrection::at(std::size_t scan, Stamp stamp, const Pose2& local_T_robot) const {
  if (keys_.empty()) return {};
  const auto after =
      std::upper_bound(keys_.begin(), keys_.end(), scan,
                       [](std::size_t place, const KeyScan& key) { return place < key.scan; });
  const auto next = static_cast<std::size_t>(after - keys_.begin());
  const std::size_t last = next > 0 ? next - 1 : 0;
  if (next == keys_.size() || next == 0 || stamp <= keys_[last].stamp) return map_T_local_[last];
  // Between two drives nobody moved: a scan belongs to the one that is nearer in time.
  if (keys_[next].starts_drive) {
    const bool is_before = stamp - keys_[last].stamp < keys_[next].stamp - stamp;
    return map_T_local_[is_before ? last : next];
  }
  const auto& [from, to] = changes_[next];
  if (stamp <= from) return map_T_local_[last];
  // Stamps may repeat, or go back.
  if (stamp >= to) return map_T_local_[next];
  const double ratio = (stamp - from).seconds() / (to - from).seconds();
  const Pose2 first = map_T_local_[last] * local_T_robot;
  const Pose2 second = map_T_local_[next] * local_T_robot;
  return interpolate(first, second, ratio) * local_T_robot.inverse();
}

}  // namespace loopstone
