#include "formats/topic_log_writer.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/message_scan.hpp"
#include "formats/ros_geometry.hpp"

namespace loopstone {
namespace {

constexpr const char* kBase = "base_link";
constexpr const char* kOdom = "odom";

/// "/scan", "/scan_2", "/scan_3".
std::string numbered(const std::string& name, int lidar) {
  return lidar == 0 ? name : fmt::format("{}_{}", name, lidar + 1);
}

class TopicLogWriter final : public LogWriter {
 public:
  TopicLogWriter(std::unique_ptr<RecordingWriter> writer, RobotModel robot)
      : writer_(std::move(writer)), robot_(std::move(robot)) {}

  void write(const SensorMessage& message) override {
    std::visit([this](const auto& reading) { add(reading); }, message);
  }
  void finish() override { writer_->finish(); }

  std::vector<std::string> notes() const override {
    if (moved_ == 0) return {};
    return {fmt::format(
        "{} scans state another mount of their laser than its first one, which is written",
        moved_)};
  }

 private:
  void add(const LaserScan& scan) {
    const std::string frame = numbered("laser", scan.lidar);
    add_mount(scan, frame);
    send(numbered("/scan", scan.lidar), scan.stamp, to_message(scan, frame));
  }

  void add_mount(const LaserScan& scan, const std::string& frame) {
    const Pose2 mount = mount_of(scan, robot_);
    const auto [known, is_new] = mounts_.try_emplace(scan.lidar, mount);
    if (!is_new) {
      if (known->second.vector() != mount.vector()) ++moved_;
      return;
    }
    const auto index = static_cast<std::size_t>(scan.lidar);
    const double height_m = index < robot_.lidars.size() ? robot_.lidars[index].height_m : 0.0;
    send_transform("/tf_static", scan.stamp, kBase, frame, mount, height_m);
  }

  void add(const OdometryPose& odometry) {
    const Pose2& pose = odometry.odom_T_robot;
    msg::Odometry message{.header = {odometry.stamp, kOdom}, .child_frame_id = kBase};
    message.pose.pose.position = {.x = pose.x, .y = pose.y};
    message.pose.pose.orientation = to_quaternion(pose.yaw);
    send("/odom", odometry.stamp, message);
    send_transform("/tf", odometry.stamp, kOdom, kBase, pose, 0.0);
  }

  void add(const ImuSample& imu) {
    msg::Imu message{.header = {imu.stamp, kBase}};
    message.orientation_covariance[0] = -1.0;  // by the message's definition: not measured
    const auto to_vector = [](const Eigen::Vector3d& v) {
      return msg::Vector3{.x = v.x(), .y = v.y(), .z = v.z()};
    };
    message.angular_velocity = to_vector(imu.angular_velocity_rad_s);
    message.linear_acceleration = to_vector(imu.linear_acceleration_m_s2);
    send("/imu/data", imu.stamp, message);
  }

  void add(const WheelTicks& ticks) {
    send("/wheel_ticks", ticks.stamp,
         msg::WheelTicks{.header = {ticks.stamp, kBase}, .counts = ticks.counts});
  }

  void add(const RgbdFrame& /*frame*/) {}  // the format has no place for pictures

  void send_transform(const std::string& topic, Stamp stamp, const std::string& parent,
                      const std::string& child, const Pose2& pose, double height_m) {
    msg::TransformStamped transform{.header = {stamp, parent}, .child_frame_id = child};
    transform.transform.translation = {.x = pose.x, .y = pose.y, .z = height_m};
    transform.transform.rotation = to_quaternion(pose.yaw);
    send(topic, stamp, msg::TFMessage{{std::move(transform)}}, topic == "/tf_static");
  }

  template <typename M>
  void send(const std::string& topic, Stamp stamp, const M& message, bool latched = false) {
    auto known = topics_.find(topic);
    if (known == topics_.end()) {
      const std::size_t number = writer_->add_topic(written_topic<M>(topic, latched));
      known = topics_.emplace(topic, number).first;
    }
    encode_message(writer_->wire_format(), message, bytes_);
    writer_->write(known->second, stamp, bytes_);
  }

  std::unique_ptr<RecordingWriter> writer_;
  RobotModel robot_;
  std::map<std::string, std::size_t> topics_{};
  std::map<int, Pose2> mounts_{};  ///< that were written, by lidar
  std::int64_t moved_ = 0;
  std::string bytes_{};
};

}  // namespace

std::unique_ptr<LogWriter> create_topic_log(std::unique_ptr<RecordingWriter> writer,
                                            const RobotModel& robot) {
  return std::make_unique<TopicLogWriter>(std::move(writer), robot);
}

}  // namespace loopstone
