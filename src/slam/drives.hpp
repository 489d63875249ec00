#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// Which submaps are of one drive, and which drives are tied to one another by closures that stand.
/// Of two places in drives that nothing ties, poses say nothing: one drive is adrift to the other.
class Drives {
 public:
  /// By SubmapRecord::closed_with.
  explicit Drives(std::span<const SubmapRecord> submaps);

  [[nodiscard]] bool any_adrift() const { return count_ > 1; }
  [[nodiscard]] bool are_adrift(SubmapId a, SubmapId b) const {
    return groups_[a.index] != groups_[b.index];
  }
  /// The submaps that hang together with one.
  [[nodiscard]] std::vector<SubmapId> with(SubmapId submap) const;

 private:
  std::vector<std::size_t> groups_{};  ///< of each submap
  std::size_t count_ = 0;
};

}  // namespace loopstone
