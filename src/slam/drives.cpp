#include "slam/drives.hpp"

#include <algorithm>
#include <numeric>

namespace loopstone {

namespace {

std::size_t root_of(std::vector<std::size_t>& parents, std::size_t at) {
  while (parents[at] != at) at = parents[at] = parents[parents[at]];
  return at;
}

}  // namespace

Drives::Drives(std::span<const SubmapRecord> submaps) : groups_(submaps.size()) {
  std::size_t drive = 0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    if (i > 0 && !submaps[i].keys.empty() && submaps[i].keys.front().starts_drive) ++drive;
    groups_[i] = drive;
  }
  std::vector<std::size_t> parents(drive + 1);
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (std::size_t i = 0; drive > 0 && i < submaps.size(); ++i) {
    for (const SubmapId other : submaps[i].closed_with) {
      const std::size_t one = root_of(parents, groups_[i]);
      const std::size_t two = root_of(parents, groups_[other.index]);
      parents[std::max(one, two)] = std::min(one, two);
    }
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
