#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// A frame's name without the slash that ROS 1 may have put before it.
[[nodiscard]] std::string frame_name(std::string_view name);

/// Frames of a robot and what lies between them (tf): every frame has one parent at most. Bounded
/// memory: of a frame that moves the last kKept is remembered.
class FrameTree {
 public:
  static constexpr Duration kKept{20'000'000'000};
  static constexpr std::size_t kMostKept = 20'000;
  static constexpr std::size_t kMostFrames = 10'000;
  /// Before the first and after the last pose of a frame that moves, so far.
  static constexpr Duration kReach{1'000'000'000};

  void add_fixed(const std::string& parent, const std::string& child, const Pose3& parent_T_child);
  /// A pose that was published with a time; a frame that never moves is as good as fixed.
  void add(const std::string& parent, const std::string& child, Stamp stamp,
           const Pose3& parent_T_child);

  [[nodiscard]] bool has(std::string_view frame) const;
  /// Of all frames.
  [[nodiscard]] const std::set<std::string, std::less<>>& names() const { return frames_; }
  /// target_T_source. Nothing when they are not connected, or a frame between them moves and was
  /// not told near that time.
  /// \param stamp  absent: as they were told last
  [[nodiscard]] std::optional<Pose3> find(std::string_view target, std::string_view source,
                                          std::optional<Stamp> stamp = {}) const;
  /// The pose of `base` in the frame in which that of `child` is told; as it is when nothing tells
  /// what lies between the two.
  [[nodiscard]] Pose3 pose_of(std::string_view base, std::string_view child,
                              const Pose3& told_T_child) const;
  /// Whether something between the two moved so far.
  [[nodiscard]] bool moves(std::string_view target, std::string_view source) const;
  /// From a frame up to its root, itself first.
  [[nodiscard]] std::vector<std::string> ancestry(std::string_view frame) const;
  /// The parent, if there is one.
  [[nodiscard]] std::optional<std::string> parent_of(std::string_view frame) const;
  /// What did not move so far, without the rest and without times.
  [[nodiscard]] FrameTree standing() const;
  /// Frames whose parent was told to be another one before: a sign of two robots or two programs.
  [[nodiscard]] const std::vector<std::string>& contested() const { return contested_; }

 private:
  struct StampedPose3 {
    Stamp stamp{};
    Pose3 pose{};
  };
  /// From a frame to its parent.
  struct Link {
    std::string parent{};
    bool is_fixed = false;
    bool is_timed = false;  ///< the times below are of the clock that is used
    Stamp since{};          ///< it was told first
    StampedPose3 last{};
    std::deque<StampedPose3> past{};  ///< empty as long as it did not move
  };

  Link* link_to(const std::string& parent, const std::string& child);
  [[nodiscard]] static std::optional<Pose3> pose_at(const Link& link, std::optional<Stamp> at);
  /// root_T_frame for each frame on the way up; nothing when a pose is missing.
  [[nodiscard]] std::optional<Pose3> up_to(std::string_view ancestor, std::string_view frame,
                                           std::optional<Stamp> stamp) const;
  [[nodiscard]] std::optional<std::string> common_ancestor(std::string_view a,
                                                           std::string_view b) const;

  std::map<std::string, Link, std::less<>> links_{};
  std::set<std::string, std::less<>> frames_{};
  std::vector<std::string> contested_{};
};

}  // namespace loopstone
