#include "formats/frame_tree.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

/// What two programs that publish the same mount may differ by.
constexpr double kSameM = 1e-5;
constexpr double kSameQuaternion = 1e-6;

bool same(const Pose3& a, const Pose3& b) {
  const double turned = 1.0 - std::abs(a.rotation.dot(b.rotation));
  return (a.translation - b.translation).norm() < kSameM && turned < kSameQuaternion;
}

Pose3 between(const Pose3& a, const Pose3& b, double share) {
  return {a.translation + share * (b.translation - a.translation),
          a.rotation.slerp(share, b.rotation)};
}

}  // namespace

std::string frame_name(std::string_view name) {
  while (!name.empty() && name.front() == '/') name.remove_prefix(1);
  return std::string(name);
}

FrameTree::Link* FrameTree::link_to(const std::string& parent, const std::string& child) {
  if (parent == child || child.empty() || parent.empty()) return nullptr;
  if (const auto known = links_.find(child); known != links_.end()) {
    if (known->second.parent == parent) return &known->second;
    if (std::ranges::find(contested_, child) == contested_.end()) contested_.push_back(child);
    return nullptr;
  }
  if (links_.size() >= kMostFrames) return nullptr;
  // A loop would never end.
  for (const std::string& above : ancestry(parent)) {
    if (above == child) return nullptr;
  }
  frames_.insert(parent);
  frames_.insert(child);
  return &links_.emplace(child, Link{.parent = parent}).first->second;
}

void FrameTree::add_fixed(const std::string& parent, const std::string& child,
                          const Pose3& parent_T_child) {
  Link* const link = link_to(parent, child);
  if (link == nullptr) return;
  link->is_fixed = true;
  link->last = {.pose = parent_T_child};
  link->past.clear();
}

void FrameTree::add(const std::string& parent, const std::string& child, Stamp stamp,
                    const Pose3& parent_T_child) {
  Link* const link = link_to(parent, child);
  if (link == nullptr || link->is_fixed) return;
  const StampedPose3 told{stamp, parent_T_child};
  if (!link->is_timed) {
    link->is_timed = true;
    link->since = stamp;
    link->last = told;
    return;
  }
  if (link->past.empty() && same(link->last.pose, parent_T_child)) {
    link->since = std::min(link->since, stamp);
    link->last.stamp = std::max(link->last.stamp, stamp);
    return;
  }
  // Of several programs' stamps some go back.
  if (stamp <= link->last.stamp) return;
  if (link->past.empty()) {
    // It stood there all the time.
    if (link->since < link->last.stamp) link->past.push_back({link->since, link->last.pose});
    link->past.push_back(link->last);
  }
  link->past.push_back(told);
  link->last = told;
  while (link->past.size() > kMostKept ||
         (link->past.size() > 2 && stamp - link->past[1].stamp > kKept)) {
    link->past.pop_front();
  }
}

bool FrameTree::has(std::string_view frame) const { return frames_.contains(frame); }

std::optional<std::string> FrameTree::parent_of(std::string_view frame) const {
  const auto link = links_.find(frame);
  if (link == links_.end()) return std::nullopt;
  return link->second.parent;
}

std::vector<std::string> FrameTree::ancestry(std::string_view frame) const {
  std::vector<std::string> frames{std::string(frame)};
  while (const auto parent = parent_of(frames.back())) frames.push_back(*parent);
  return frames;
}

std::optional<std::string> FrameTree::common_ancestor(std::string_view a,
                                                      std::string_view b) const {
  const std::vector<std::string> above = ancestry(a);
  const std::set<std::string_view> above_a(above.begin(), above.end());
  for (const std::string& frame : ancestry(b)) {
    if (above_a.contains(frame)) return frame;
  }
  return std::nullopt;
}

std::optional<Pose3> FrameTree::pose_at(const Link& link, std::optional<Stamp> at) {
  if (!at || link.past.empty()) return link.last.pose;
  const Stamp stamp = *at;
  const auto after =
      std::ranges::lower_bound(link.past, stamp, {}, [](const StampedPose3& p) { return p.stamp; });
  if (after == link.past.begin()) {
    if (after->stamp - stamp > kReach) return std::nullopt;
    return after->pose;
  }
  const auto before = std::prev(after);
  if (after == link.past.end()) {
    if (stamp - before->stamp > kReach) return std::nullopt;
    return before->pose;
  }
  const double share = (stamp - before->stamp).seconds() / (after->stamp - before->stamp).seconds();
  return between(before->pose, after->pose, share);
}

std::optional<Pose3> FrameTree::up_to(std::string_view ancestor, std::string_view frame,
                                      std::optional<Stamp> stamp) const {
  Pose3 ancestor_T_frame;
  std::string at(frame);
  while (at != ancestor) {
    const Link& link = links_.find(at)->second;
    const auto parent_T_at = pose_at(link, stamp);
    if (!parent_T_at) return std::nullopt;
    ancestor_T_frame = *parent_T_at * ancestor_T_frame;
    at = link.parent;
  }
  return ancestor_T_frame;
}

std::optional<Pose3> FrameTree::find(std::string_view target, std::string_view source,
                                     std::optional<Stamp> stamp) const {
  if (target == source) return Pose3{};
  const auto common = common_ancestor(target, source);
  if (!common) return std::nullopt;
  const auto common_T_target = up_to(*common, target, stamp);
  const auto common_T_source = up_to(*common, source, stamp);
  if (!common_T_target || !common_T_source) return std::nullopt;
  return common_T_target->inverse() * *common_T_source;
}

Pose3 FrameTree::pose_of(std::string_view base, std::string_view child,
                         const Pose3& told_T_child) const {
  if (child.empty() || base.empty() || child == base) return told_T_child;
  const auto child_T_base = find(child, base);
  return child_T_base ? told_T_child * *child_T_base : told_T_child;
}

FrameTree FrameTree::standing() const {
  FrameTree result;
  for (const auto& [child, link] : links_) {
    if (!link.past.empty()) continue;
    result.links_.emplace(
        child,
        Link{.parent = link.parent, .is_fixed = link.is_fixed, .last = {.pose = link.last.pose}});
    result.frames_.insert(child);
    result.frames_.insert(link.parent);
  }
  return result;
}

bool FrameTree::moves(std::string_view target, std::string_view source) const {
  const auto common = common_ancestor(target, source);
  if (!common) return false;
  for (const std::string_view end : {target, source}) {
    for (std::string at(end); at != *common; at = links_.find(at)->second.parent) {
      if (!links_.find(at)->second.past.empty()) return true;
    }
  }
  return false;
}

}  // namespace loopstone
