#include "live/node_track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "live/still.hpp"

namespace loopstone {
namespace {

bool is_same(const ViewNode& a, const ViewNode& b) {
  constexpr double kSameSigmaM = 1e-3;
  return a.stamp == b.stamp && a.submap == b.submap && a.drive == b.drive &&
         is_still(a.map_T_robot, b.map_T_robot) && std::abs(a.sigma_m - b.sigma_m) < kSameSigmaM;
}

}  // namespace

std::optional<msg::Trajectory> NodeTrack::change(std::vector<ViewNode> nodes) {
  const auto [was, is] = std::ranges::mismatch(nodes_, nodes, is_same);
  const auto first = static_cast<std::size_t>(was - nodes_.begin());
  if (was == nodes_.end() && is == nodes.end()) return {};
  // What has not moved stays as it was told, so that many small steps do not go unseen.
  nodes_.resize(first);
  nodes_.insert(nodes_.end(), nodes.begin() + static_cast<std::ptrdiff_t>(first), nodes.end());
  return message_from(first);
}

msg::Trajectory NodeTrack::message_from(std::size_t first) const {
  msg::Trajectory message{.first = static_cast<std::uint32_t>(first),
                          .count = static_cast<std::uint32_t>(nodes_.size())};
  for (std::size_t i = first; i < nodes_.size(); ++i) {
    const ViewNode& node = nodes_[i];
    message.t.push_back(node.stamp.seconds());
    for (const double value : {node.map_T_robot.x, node.map_T_robot.y, node.map_T_robot.yaw})
      message.poses.push_back(static_cast<float>(value));
    message.sigma.push_back(static_cast<float>(node.sigma_m));
    message.submaps.push_back(node.submap);
    message.drives.push_back(node.drive);
  }
  return message;
}

}  // namespace loopstone
