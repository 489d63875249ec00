#include "formats/carmen_writer.hpp"

#include <charconv>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "formats/carmen_scan.hpp"
#include "formats/packed_file.hpp"

namespace loopstone {
namespace {

// SICK's code for "nothing within reach", as CARMEN wrote it; above the 80 m that CARMEN takes as
// the limit.
constexpr double kSickNoReturn_m = 81.83;
constexpr double kCarmenMaxRange_m = 80.0;
constexpr std::size_t kMostWaiting = 512;

/// Builds a line word by word.
class LineText {
 public:
  explicit LineText(std::string_view tag) : text_(tag) {}

  template <typename Number>
  LineText& add(Number value) {
    char digits[64];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    text_ += ' ';
    text_.append(digits, error == std::errc{} ? end : digits);
    return *this;
  }
  LineText& add(const Pose2& pose) { return add(pose.x).add(pose.y).add(pose.yaw); }
  LineText& add(Stamp stamp) {
    const bool negative = stamp.nanoseconds < 0;
    const std::int64_t whole = std::abs(stamp.nanoseconds / 1'000'000'000);
    const std::int64_t rest = std::abs(stamp.nanoseconds % 1'000'000'000);
    const std::string decimals = std::to_string(rest);
    text_ += negative ? " -" : " ";
    text_ += std::to_string(whole) + "." + std::string(9 - decimals.size(), '0') + decimals;
    return *this;
  }
  LineText& add_word(std::string_view word) {
    text_ += ' ';
    text_ += word;
    return *this;
  }
  /// The three words that close every line, and its end.
  std::string closed(Stamp stamp) {
    add(stamp).add_word("loopstone").add(stamp);
    text_ += '\n';
    return std::move(text_);
  }

 private:
  std::string text_;
};

class CarmenWriter final : public LogWriter {
 public:
  CarmenWriter(const std::string& path, RobotModel robot)
      : path_(path), file_(path), robot_(std::move(robot)) {
    file_.write(
        "# CARMEN log\n"
        "# FLASER n ranges x y theta odom_x odom_y odom_theta ipc_time host logger_time\n"
        "# ROBOTLASER1 type start fov resolution max_range accuracy remission_mode n ranges m "
        "remissions laser_x laser_y laser_theta x y theta tv rv forward side turn_axis ipc_time "
        "host logger_time\n"
        "# ODOM x y theta tv rv accel ipc_time host logger_time\n");
  }

  /// Only scans and poses are given: the format holds nothing else.
  void write(const SensorMessage& message) override {
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      take(*scan);
    } else if (const auto* odometry = std::get_if<OdometryPose>(&message)) {
      take(*odometry);
    }
  }

  void finish() override {
    write_odometry_line();
    for (const LaserScan& scan : waiting_) write_scan(scan, last_pose());
    waiting_.clear();
    file_.commit();
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (scans_without_odometry_ > 0) {
      notes.push_back(std::to_string(scans_without_odometry_) +
                      " scans have no odometry pose (RAWLASER1)");
    }
    return notes;
  }

 private:
  void take(const OdometryPose& odometry) {
    while (!waiting_.empty()) {
      const LaserScan& scan = waiting_.front();
      write_scan(scan, between(odometry, scan.stamp));
      waiting_.pop_front();
    }
    write_odometry_line();
    last_ = odometry;
    line_waits_ = true;
  }

  void take(const LaserScan& scan) {
    if (last_ && last_->stamp == scan.stamp) {
      line_waits_ = false;  // the scan's line carries the pose
      write_scan(scan, last_->odom_T_robot);
      return;
    }
    write_odometry_line();
    waiting_.push_back(scan);
    if (waiting_.size() <= kMostWaiting) return;
    write_scan(waiting_.front(), last_pose());
    waiting_.pop_front();
  }

  /// The line of odometry that no scan of the same stamp followed.
  void write_odometry_line() {
    if (last_ && line_waits_) {
      file_.write(
          LineText("ODOM").add(last_->odom_T_robot).add(0).add(0).add(0).closed(last_->stamp));
    }
    line_waits_ = false;
  }

  std::optional<Pose2> last_pose() const {
    if (!last_) return std::nullopt;
    return last_->odom_T_robot;
  }
  Pose2 between(const OdometryPose& next, Stamp stamp) const {
    if (!last_ || next.stamp <= last_->stamp) return next.odom_T_robot;
    const double ratio = (stamp - last_->stamp).seconds() / (next.stamp - last_->stamp).seconds();
    return interpolate(last_->odom_T_robot, next.odom_T_robot, ratio);
  }

  void write_params(const LaserScan& scan) {
    const Pose2 mount = mount_of(scan, robot_);
    LineText offset("PARAM robot_frontlaser_offset");
    file_.write(offset.add(mount.x).closed(scan.stamp));
    if (scan.range_max_m < kCarmenMaxRange_m) {
      LineText limit("PARAM robot_front_laser_max");
      file_.write(limit.add(scan.range_max_m).closed(scan.stamp));
    }
    stated_max_m_ = scan.range_max_m;
  }

  static bool follows_carmens_rule(const LaserScan& scan) {
    const BeamAngles rule = carmen_beam_angles(scan.ranges_m.size(), {}, scan.lidar);
    // Within a thousandth of a beam at the last one.
    const auto last = static_cast<double>(scan.ranges_m.size());
    const double increment_error = std::abs(rule.angle_increment_rad - scan.angle_increment_rad);
    return std::abs(rule.angle_min_rad - scan.angle_min_rad) < 1e-6 &&
           increment_error * last < 1e-3 * std::abs(rule.angle_increment_rad);
  }

  void add_ranges(const LaserScan& scan, LineText& line) const {
    const double no_return_m =
        scan.range_max_m < kCarmenMaxRange_m ? scan.range_max_m : kSickNoReturn_m;
    line.add(scan.ranges_m.size());
    for (const float range_m : scan.ranges_m) {
      if (std::isnan(range_m)) {
        line.add(0);
      } else if (std::isinf(range_m)) {
        line.add(static_cast<float>(std::max(no_return_m, scan.range_max_m)));
      } else {
        line.add(range_m);
      }
    }
  }

  void write_scan(const LaserScan& scan, const std::optional<Pose2>& odom_T_robot) {
    if (scan.lidar >= kCarmenLidars) {
      throw DataError({path_}, "CARMEN text can't hold this log: scanner " +
                                   std::to_string(scan.lidar + 1) + " of several");
    }
    if (scan.lidar == 0 && !stated_max_m_) write_params(scan);
    if (!odom_T_robot) ++scans_without_odometry_;

    const bool in_short = odom_T_robot && scan.lidar < 2 && follows_carmens_rule(scan) &&
                          (scan.range_max_m == stated_max_m_ || scan.lidar == 1);
    file_.write(in_short ? short_line(scan, *odom_T_robot) : long_line(scan, odom_T_robot));
  }

  std::string short_line(const LaserScan& scan, const Pose2& odom_T_robot) const {
    LineText line(scan.lidar == 0 ? "FLASER" : "RLASER");
    add_ranges(scan, line);
    return line.add(odom_T_robot * mount_of(scan, robot_)).add(odom_T_robot).closed(scan.stamp);
  }

  std::string long_line(const LaserScan& scan, const std::optional<Pose2>& odom_T_robot) const {
    LineText line((odom_T_robot ? "ROBOTLASER" : "RAWLASER") + std::to_string(scan.lidar + 1));
    const auto steps = static_cast<double>(scan.ranges_m.size()) - 1.0;
    line.add(0).add(scan.angle_min_rad).add(scan.angle_increment_rad * steps);
    line.add(scan.angle_increment_rad).add(scan.range_max_m).add(0.01).add(0);
    add_ranges(scan, line);
    line.add(0);  // remissions
    if (odom_T_robot) {
      line.add(*odom_T_robot * mount_of(scan, robot_)).add(*odom_T_robot);
      for (int i = 0; i < 5; ++i) line.add(0);
    }
    return line.closed(scan.stamp);
  }

  std::string path_;
  PackedFile file_;
  RobotModel robot_;
  std::deque<LaserScan> waiting_;  ///< for the odometry after them
  std::optional<OdometryPose> last_;
  bool line_waits_ = false;
  std::optional<double> stated_max_m_{};  ///< by PARAM, for the short lines
  std::int64_t scans_without_odometry_ = 0;
};

}  // namespace

std::unique_ptr<LogWriter> create_carmen_log(const std::string& path, const RobotModel& robot) {
  return std::make_unique<CarmenWriter>(path, robot);
}

}  // namespace loopstone
