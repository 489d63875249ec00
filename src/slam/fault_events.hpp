#pragma once

#include <cstddef>
#include <vector>

#include "loopstone/slam/map_update.hpp"

namespace loopstone {

/// Tells what has begun or is over since it was asked last.
class FaultEvents {
 public:
  [[nodiscard]] std::vector<MapEvent> changes(const OdometryCheck& odometry,
                                              const LaserCheck& laser) {
    std::vector<MapEvent> events;
    const auto& episodes = odometry.episodes();
    odometry_over_.resize(episodes.size(), kUntold);
    for (std::size_t i = 0; i < episodes.size(); ++i) {
      const char now = episodes[i].over ? kOver : kBegun;
      if (odometry_over_[i] != now) events.emplace_back(OdometryFaultChanged{episodes[i]});
      odometry_over_[i] = now;
    }
    const auto& faults = laser.episodes();
    laser_over_.resize(faults.size(), kUntold);
    for (std::size_t i = 0; i < faults.size(); ++i) {
      const bool over = !laser.is_open(i);
      const char now = over ? kOver : kBegun;
      if (laser_over_[i] != now) events.emplace_back(LaserFaultChanged{faults[i], over});
      laser_over_[i] = now;
    }
    return events;
  }

 private:
  static constexpr char kUntold = 0;
  static constexpr char kBegun = 1;
  static constexpr char kOver = 2;
  std::vector<char> odometry_over_{};  ///< an episode, what was told of it last
  std::vector<char> laser_over_{};
};

}  // namespace loopstone
