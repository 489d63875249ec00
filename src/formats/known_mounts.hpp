#pragma once

#include <map>
#include <optional>

#include "formats/topic_names.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Where the lasers sit that were seen so far.
class KnownMounts {
 public:
  /// All of them, for whoever comes late, when that of this scan is new or has changed.
  [[nodiscard]] std::optional<msg::TFMessage> change(const LaserScan& scan,
                                                     const RobotModel& robot) {
    const msg::TransformStamped mount = mount_message(scan, robot);
    const auto [known, is_new] = mounts_.try_emplace(scan.lidar, mount);
    const auto& before = known->second.transform;
    const auto& now = mount.transform;
    if (!is_new && before.translation.x == now.translation.x &&
        before.translation.y == now.translation.y && before.rotation.z == now.rotation.z &&
        before.rotation.w == now.rotation.w)
      return {};
    known->second = mount;
    msg::TFMessage all;
    for (const auto& [lidar, transform] : mounts_) all.transforms.push_back(transform);
    return all;
  }

 private:
  std::map<int, msg::TransformStamped> mounts_{};  ///< by laser
};

}  // namespace loopstone
