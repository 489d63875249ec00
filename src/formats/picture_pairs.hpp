#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "formats/kept_stamps.hpp"

namespace loopstone {

/// One RGB-D frame of two streams: places in their lists of stamps. A picture may be alone.
struct PicturePair {
  std::optional<std::size_t> depth{};
  std::optional<std::size_t> colour{};
};

/// How far apart the pictures of a pair may be: 50 ms, or half the period of the slower stream when
/// that is more, at most 250 ms.
///
/// The pictures of a pair need not be simultaneous, since each is placed by its own stamp; they
/// must see the same floor. 50 ms bridge the jitter of free-running cameras, half a period finds a
/// partner for every picture of slow ones, and a robot at 1 m/s moves on by a quarter of its view
/// in 250 ms.
[[nodiscard]] Duration longest_pair_offset(std::span<const Stamp> depth,
                                           std::span<const Stamp> colour);

/// Pairs two streams by time: the nearest two pictures first, each used once, no pair crossing
/// another. What finds no partner stays alone. In the order of the stamps (of the depth picture
/// where there is one). Both lists increase. O(n log n).
[[nodiscard]] std::vector<PicturePair> pair_pictures(std::span<const Stamp> depth,
                                                     std::span<const Stamp> colour,
                                                     Duration longest_offset);

}  // namespace loopstone
