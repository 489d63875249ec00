#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/words.hpp"

// Recordings of ROS hold many topics. What is used of them, and for what.

namespace loopstone {

/// What a topic is used for.
enum class TopicRole {
  kNone,
  kLaser,     ///< there may be several
  kOdometry,  ///< poses of the robot's own dead reckoning
  kImu,
  kWheels,
  kTransforms,  ///< tf
  kTruth,       ///< poses to compare with
  kDepth,       ///< pictures of depth
  kColour,      ///< pictures of colour, of the same camera or one beside it
};

constexpr auto words_of(TopicRole /*any*/) {
  using enum TopicRole;
  return std::array{Word{kNone, "none"},   Word{kLaser, "laser"},   Word{kOdometry, "odometry"},
                    Word{kImu, "imu"},     Word{kWheels, "wheels"}, Word{kTransforms, "tf"},
                    Word{kTruth, "truth"}, Word{kDepth, "depth"},   Word{kColour, "colour"}};
}

/// Which of several echoes of one beam counts.
enum class EchoUse { kFirst, kStrongest };

constexpr auto words_of(EchoUse /*any*/) {
  using enum EchoUse;
  return std::array{Word{kFirst, "first"}, Word{kStrongest, "strongest"}};
}

/// Heights in the robot's frame [m], whose origin should lie on the floor.
struct HeightRange {
  double low_m = 0.0;
  double high_m = 0.0;
};

/// What is known of a robot's wheels; what is not known is not taken from another robot. From the
/// user's robot file (stated_wheels()), or from whoever has measured them.
struct StatedWheels {
  std::optional<double> metres_per_count{};
  std::optional<double> radius_m{};
  std::optional<double> track_width_m{};
  std::optional<bool> counts_are_cumulative{};  ///< absent: they are
  std::optional<int> counter_bits{};            ///< absent: those of the message's type
};

/// How a recording with topics is to be understood; other logs take no notice.
struct TopicOptions {
  /// What the user named; an empty name: no topic is to play this role. Several of kLaser all
  /// count.
  std::vector<std::pair<TopicRole, std::string>> named{};
  std::string base_frame{};  ///< the robot's frame in tf; empty: chosen
  EchoUse echo = EchoUse::kFirst;
  std::optional<HeightRange> slice{};  ///< of point clouds; absent: about the scanner's own height
  /// Pictures of a camera that sees depth and colour are looked for and given.
  bool pictures = false;
  StatedWheels wheels{};   ///< of joints and of counts by other types than our own
  bool count_all = false;  ///< topics that nobody uses are read, too, to be counted
};

/// One topic of a recording, for people.
struct TopicSummary {
  std::string name{};
  std::string type{};  ///< "sensor_msgs/LaserScan"
  std::int64_t messages = 0;
  double rate_hz = 0.0;        ///< mean over the recording; 0 with fewer than two messages
  double largest_gap_s = 0.0;  ///< by the recorder's clock; of topics that were read
  std::string frame{};         ///< of the header
  TopicRole role = TopicRole::kNone;
  std::string remark{};  ///< why it is not used, or what is wrong with it
};

}  // namespace loopstone
