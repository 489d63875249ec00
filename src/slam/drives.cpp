#include "slam/drives.hpp"

#include <numeric>

#include "loopstone/base/union_find.hpp"

namespace loopstone {

Drives::Drives(std::span<const SubmapRecord> submaps) : groups_(submaps.size()) {
  std::size_t drive = 0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (i > 0 && !submaps[i].keys.empty() && submaps[i].keys.front().starts_drive) ++drive;
    groups_[i] = drive;
  }
  std::vector<std::size_t> parents(drive + 1);
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (std::size_t i = 0; drive > 0 && i < submaps.size(); ++i) {
    for (const SubmapId other : submaps[i].closed_with)
      join(parents, groups_[i], groups_[other.index]);
  }
  for (std::size_t& group : groups_) group = root_of(parents, group);
  for (std::size_t i = 0; i < parents.size(); ++i) count_ += root_of(parents, i) == i ? 1 : 0;
}

std::vector<SubmapId> Drives::with(SubmapId submap) const {
  std::vector<SubmapId> all;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    if (groups_[i] == groups_[submap.index]) all.push_back({i});
  }
  return all;
}

}  // namespace loopstone
