#include "formats/topic_log_writer.hpp"

#include <fmt/format.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/message_scan.hpp"
#include "formats/picture_topics.hpp"
#include "formats/topic_names.hpp"
#include "formats/topic_writer.hpp"

namespace loopstone {
namespace {

class TopicLogWriter final : public LogWriter {
 public:
  TopicLogWriter(LogTarget target, std::unique_ptr<RecordingWriter> writer, RobotModel robot)
      : target_(std::move(target)),
        writer_(std::move(writer)),
        robot_(std::move(robot)),
        pictures_(robot_) {}

  void write(const SensorMessage& message) override {
    try {
      std::visit([this](const auto& reading) { add(reading); }, message);
    } catch (const MessageError& error) {
      throw DataError({target_.path}, error.what());
    }
  }
  void use_pictures(std::shared_ptr<const PictureStore> pictures) override {
    pictures_.use_pictures(std::move(pictures));
  }
  void finish() override { writer_.finish(); }

  std::vector<std::string> notes() const override {
    if (moved_ == 0) return {};
    return {fmt::format(
        "{} scans state another mount of their laser than its first one, which is written",
        moved_)};
  }

 private:
  void add(const LaserScan& scan) {
    const int most = target_.format->holds.lidars;
    if (scan.lidar < 0 || scan.lidar >= most) {
      throw DataError({target_.path}, fmt::format("has no place for laser {}: it tells {} apart",
                                                  scan.lidar + 1, most));
    }
    add_mount(scan);
    writer_.send(scan_topic(scan.lidar), scan.stamp, to_message(scan, laser_frame(scan.lidar)));
  }

  /// All of them at once whenever there is a new one: who comes late gets the last message.
  void add_mount(const LaserScan& scan) {
    const Pose2 mount = mount_of(scan, robot_);
    const auto [known, is_new] = mounts_.try_emplace(scan.lidar, mount);
    if (!is_new) {
      if (known->second.vector() != mount.vector()) ++moved_;
      return;
    }
    mount_messages_.transforms.push_back(mount_message(scan, robot_));
    writer_.send("/tf_static", scan.stamp, mount_messages_, true);
  }

  void add(const OdometryPose& odometry) {
    const Pose2& pose = odometry.odom_T_robot;
    msg::Odometry message{.header = {odometry.stamp, kOdometryFrame}, .child_frame_id = kBaseFrame};
    message.pose.pose = to_message(pose);
    writer_.send("/odom", odometry.stamp, message);
    writer_.send(
        "/tf", odometry.stamp,
        msg::TFMessage{{transform_message(odometry.stamp, kOdometryFrame, kBaseFrame, pose)}});
  }

  void add(const ImuSample& imu) {
    msg::Imu message{.header = {imu.stamp, kBaseFrame}};
    message.orientation_covariance[0] = -1.0;  // by the message's definition: not measured
    const auto to_vector = [](const Eigen::Vector3d& v) {
      return msg::Vector3{.x = v.x(), .y = v.y(), .z = v.z()};
    };
    message.angular_velocity = to_vector(imu.angular_velocity_rad_s);
    message.linear_acceleration = to_vector(imu.linear_acceleration_m_s2);
    writer_.send("/imu/data", imu.stamp, message);
  }

  void add(const WheelTicks& ticks) {
    writer_.send("/wheel_ticks", ticks.stamp,
                 msg::WheelTicks{.header = {ticks.stamp, kBaseFrame}, .counts = ticks.counts});
  }

  void add(const RgbdFrame& frame) {
    const std::vector<msg::TransformStamped> mounts = pictures_.mounts(frame.stamp, frame);
    if (frame.robot_T_camera) {
      writer_.send("/tf", frame.stamp, msg::TFMessage{mounts});
    } else if (!camera_is_mounted_) {
      auto& all = mount_messages_.transforms;
      all.insert(all.end(), mounts.begin(), mounts.end());
      writer_.send("/tf_static", frame.stamp, mount_messages_, true);
      camera_is_mounted_ = true;
    }
    pictures_.write(frame, writer_);
  }

  LogTarget target_;
  TopicWriter writer_;
  RobotModel robot_;
  PictureTopics pictures_;
  bool camera_is_mounted_ = false;
  std::map<int, Pose2> mounts_{};  ///< that were written, by lidar
  msg::TFMessage mount_messages_{};
  std::int64_t moved_ = 0;
};

}  // namespace

std::unique_ptr<LogWriter> create_topic_log(const LogTarget& target,
                                            std::unique_ptr<RecordingWriter> writer,
                                            const RobotModel& robot) {
  return std::make_unique<TopicLogWriter>(target, std::move(writer), robot);
}

}  // namespace loopstone
