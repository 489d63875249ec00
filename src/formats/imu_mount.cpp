#include "formats/imu_mount.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kGravity = 9.81;
/// A mean of accelerations within this of gravity is gravity.
constexpr double kNearGravity = 1.5;
/// No floor is so steep, no unit so badly made.
constexpr double kMostOffDeg = 30.0;

}  // namespace

ImuMount imu_mount(const std::optional<Eigen::Quaterniond>& by_tf, const Eigen::Vector3d& force) {
  const bool feels_gravity = std::abs(force.norm() - kGravity) < kNearGravity;
  ImuMount mount;
  if (by_tf) mount.robot_R_imu = *by_tf;
  if (!feels_gravity) {
    if (!by_tf) mount.note = "tf does not tell how it is mounted: its z is taken for up";
    return mount;
  }
  const Eigen::Vector3d up = mount.robot_R_imu * force.normalized();
  const double off_deg = degrees(std::acos(std::clamp(up.z(), -1.0, 1.0)));
  if (by_tf && off_deg <= kMostOffDeg) return mount;
  mount.robot_R_imu =
      Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()) * mount.robot_R_imu;
  if (by_tf) {
    mount.warning = fmt::format(
        "gravity points {:.0f} deg elsewhere than tf says; up is where gravity is", off_deg);
  } else {
    mount.note = "tf does not tell how it is mounted: up is taken from gravity";
  }
  return mount;
}

}  // namespace loopstone
