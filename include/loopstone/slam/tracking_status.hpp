#pragma once

#include "loopstone/base/words.hpp"

namespace loopstone {

/// What holds the robot's pose at a scan.
enum class TrackingStatus {
  kTracked,     ///< the laser, in every direction
  kDegenerate,  ///< the laser, but for one direction (a corridor); odometry holds that one
  kBridged,     ///< odometry, or for a second the motion as it was: the laser says nothing
  kLost,        ///< nothing: the scan contradicts the map, or there is neither scan nor odometry
};

constexpr auto words_of(TrackingStatus /*any*/) {
  using enum TrackingStatus;
  return std::array{Word{kTracked, "tracked"}, Word{kDegenerate, "degenerate"},
                    Word{kBridged, "bridged"}, Word{kLost, "lost"}};
}

}  // namespace loopstone
