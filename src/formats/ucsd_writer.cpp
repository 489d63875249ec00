#include "formats/ucsd_writer.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "formats/npz_writer.hpp"
#include "formats/range_file.hpp"
#include "formats/ucsd_picture_copies.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr double kStandardGravity_m_s2 = 9.80665;

template <typename T>
std::span<const char> bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Columns of a matrix, one for each stamp, in Fortran order.
struct Columns {
  std::vector<double> stamps_s{};
  std::vector<double> values{};
};

/// The narrowest type that holds the counts: int16 as in the originals, if it can.
void add_counts(NpzWriter& file, const std::vector<std::int64_t>& counts) {
  const std::int64_t shape[] = {4, static_cast<std::int64_t>(counts.size() / 4)};
  bool fits = true;
  for (const std::int64_t count : counts) {
    fits = fits && count >= std::numeric_limits<std::int16_t>::min() &&
           count <= std::numeric_limits<std::int16_t>::max();
  }
  if (!fits) return file.add("counts", "<i8", true, shape, bytes_of(counts));
  std::vector<std::int16_t> narrow;
  narrow.reserve(counts.size());
  for (const std::int64_t count : counts) narrow.push_back(static_cast<std::int16_t>(count));
  file.add("counts", "<i2", true, shape, bytes_of(narrow));
}

class UcsdWriter final : public LogWriter {
 public:
  UcsdWriter(const std::string& folder, RobotModel robot, int set)
      : folder_(folder), robot_(std::move(robot)), set_(std::to_string(set)) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error || !fs::is_directory(folder_)) {
      throw DataError({folder}, "the folder can't be made: " + error.message());
    }
  }

  void write(const SensorMessage& message) override {
    std::visit([this](const auto& reading) { take(reading); }, message);
  }

  void finish() override {
    // All files are complete on disk before the first appears under its name.
    std::vector<AtomicFile> files;
    if (!wheel_stamps_s_.empty()) files.push_back(encoders().write());
    if (!rates_.stamps_s.empty()) files.push_back(imu().write());
    if (!poses_.stamps_s.empty()) files.push_back(odometry().write());
    if (!colour_stamps_s_.empty() || !depth_stamps_s_.empty()) files.push_back(kinect().write());
    if (ranges_) files.push_back(hokuyo().write());
    if (files.empty()) throw DataError({folder_.string()}, "nothing to write: the log is empty");
    for (AtomicFile& file : files) file.finish_writing();
    if (colour_) colour_->finish();
    if (depth_) depth_->finish();
    for (AtomicFile& file : files) file.commit();
    ranges_.reset();
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (!poses_.stamps_s.empty()) {
      notes.push_back("the odometry poses are in Odometry" + set_ +
                      ".npz, which other readers of this layout don't know");
    }
    if (states_mount_) {
      notes.push_back("the laser's mount is in Hokuyo" + set_ +
                      ".npz as robot_T_lidar, which other readers of this layout don't know");
    }
    if (frames_left_out_ > 0) {
      notes.push_back(std::to_string(frames_left_out_) +
                      " RGB-D frames of a recording are left out: the layout holds pictures that "
                      "are files");
    }
    if (has_plain_depth_ && depth_) {
      notes.push_back("the depth pictures are in dataRGBD/Depth" + set_ +
                      ", which other readers of this layout don't know");
    }
    return notes;
  }

 private:
  [[nodiscard]] std::string path(const char* sensor) const {
    return (folder_ / (sensor + set_ + ".npz")).string();
  }

  void take(const WheelTicks& ticks) {
    const auto& wheels = robot_.wheels;
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      // The layout holds differences.
      const std::int64_t count = ticks.counts[wheel];
      const bool first = !last_counts_;
      counts_.push_back(!wheels.counts_are_cumulative ? count
                        : first                       ? 0
                                                      : difference(count, (*last_counts_)[wheel]));
    }
    last_counts_ = ticks.counts;
    wheel_stamps_s_.push_back(ticks.stamp.seconds());
  }

  /// Of a counter that may have wrapped: the difference nearest to zero.
  [[nodiscard]] std::int64_t difference(std::int64_t later, std::int64_t earlier) const {
    const int bits = robot_.wheels.counter_bits;
    if (bits <= 0 || bits >= 63) return later - earlier;
    const std::int64_t turn = std::int64_t{1} << bits;
    std::int64_t step = (later - earlier) % turn;
    if (step >= turn / 2) step -= turn;
    if (step < -turn / 2) step += turn;
    return step;
  }

  void take(const ImuSample& sample) {
    rates_.stamps_s.push_back(sample.stamp.seconds());
    for (int axis = 0; axis < 3; ++axis) {
      rates_.values.push_back(sample.angular_velocity_rad_s[axis]);
      accelerations_.push_back(sample.linear_acceleration_m_s2[axis] / kStandardGravity_m_s2);
    }
  }

  void take(const OdometryPose& odometry) {
    poses_.stamps_s.push_back(odometry.stamp.seconds());
    const Pose2& pose = odometry.odom_T_robot;
    poses_.values.insert(poses_.values.end(), {pose.x, pose.y, pose.yaw});
  }

  void take(const RgbdFrame& frame) {
    if (frame.colour_message >= 0 || frame.depth_message >= 0) {
      ++frames_left_out_;
      return;
    }
    const fs::path pictures = folder_ / "dataRGBD";
    if (!frame.colour_path.empty()) {
      if (!colour_) colour_.emplace(pictures / ("RGB" + set_), "rgb" + set_ + "_");
      colour_->add(frame.colour_path);
      colour_stamps_s_.push_back(frame.colour_stamp.seconds());
    }
    if (!frame.depth_path.empty()) {
      if (!depth_) {
        const fs::path source(frame.depth_path);
        // Metres as floats can't be disparities; nor is what another log of this layout calls
        // depth.
        has_plain_depth_ = robot_.camera.encoding.kind == DepthKind::kDepth ||
                           source.filename().string().starts_with("depth") ||
                           (source.extension() != ".png" && source.extension() != ".pgm");
        depth_.emplace(pictures / ((has_plain_depth_ ? "Depth" : "Disparity") + set_),
                       (has_plain_depth_ ? "depth" : "disparity") + set_ + "_");
      }
      depth_->add(frame.depth_path);
      depth_stamps_s_.push_back(frame.stamp.seconds());
    }
  }

  void take(const LaserScan& scan) {
    if (!ranges_) {
      layout_ = scan;
      layout_.ranges_m.clear();
      beams_ = scan.ranges_m.size();
      states_mount_ = scan.robot_T_lidar.has_value();
      if (beams_ == 0) throw DataError({path("Hokuyo")}, "a scan without beams can't be written");
      ranges_.emplace((folder_ / ("Hokuyo" + set_ + ".ranges")).string(),
                      static_cast<std::int64_t>(beams_));
    }
    check_layout(scan);
    column_ = scan.ranges_m;
    for (float& range_m : column_) {
      if (std::isnan(range_m)) range_m = 0.0F;  // below range_min: readers pass over it
    }
    ranges_->append(column_);
    scan_stamps_s_.push_back(scan.stamp.seconds());
  }

  /// The layout states the beams once for all scans.
  void check_layout(const LaserScan& scan) const {
    const auto differs = [](double a, double b) { return std::abs(a - b) > 1e-9; };
    const char* what = nullptr;
    if (scan.lidar != layout_.lidar) what = "scans of several lasers";
    if (scan.ranges_m.size() != beams_) what = "scans with different numbers of beams";
    if (differs(scan.angle_min_rad, layout_.angle_min_rad) ||
        differs(scan.angle_increment_rad, layout_.angle_increment_rad)) {
      what = "scans with different directions of their beams";
    }
    if (differs(scan.range_max_m, layout_.range_max_m) ||
        differs(scan.time_increment_s, layout_.time_increment_s)) {
      what = "scans with different limits or sweep times";
    }
    if (what == nullptr) return;
    throw DataError({path("Hokuyo")}, std::string("the UCSD layout can't hold ") + what +
                                          " (from " + std::to_string(scan.stamp.seconds()) +
                                          " s on); CARMEN text can");
  }

  NpzWriter encoders() const {
    NpzWriter file(path("Encoders"));
    add_counts(file, counts_);
    file.add_row("time_stamps", wheel_stamps_s_);
    return file;
  }
  NpzWriter imu() const {
    NpzWriter file(path("Imu"));
    const std::int64_t shape[] = {3, static_cast<std::int64_t>(rates_.stamps_s.size())};
    file.add("angular_velocity", "<f8", true, shape, bytes_of(rates_.values));
    file.add("linear_acceleration", "<f8", true, shape, bytes_of(accelerations_));
    file.add_row("time_stamps", rates_.stamps_s);
    return file;
  }
  NpzWriter odometry() const {
    NpzWriter file(path("Odometry"));
    const std::int64_t shape[] = {3, static_cast<std::int64_t>(poses_.stamps_s.size())};
    file.add("poses", "<f8", true, shape, bytes_of(poses_.values));
    file.add_row("time_stamps", poses_.stamps_s);
    return file;
  }
  NpzWriter kinect() const {
    NpzWriter file(path("Kinect"));
    file.add_row(has_plain_depth_ ? "depth_time_stamps" : "disparity_time_stamps", depth_stamps_s_);
    file.add_row("rgb_time_stamps", colour_stamps_s_);
    return file;
  }
  NpzWriter hokuyo() {
    NpzWriter file(path("Hokuyo"));
    const auto steps = static_cast<double>(beams_) - 1.0;
    file.add_number("angle_min", layout_.angle_min_rad);
    file.add_number("angle_max", layout_.angle_min_rad + steps * layout_.angle_increment_rad);
    file.add_number("angle_increment", layout_.angle_increment_rad);
    file.add_number("range_min", layout_.range_min_m);
    file.add_number("range_max", layout_.range_max_m);
    file.add_file("ranges", ranges_->finish());
    file.add_row("time_stamps", scan_stamps_s_);
    if (layout_.time_increment_s != 0.0) {
      file.add_number("time_increment", layout_.time_increment_s);
    }
    if (states_mount_) {
      const Pose2& mount = *layout_.robot_T_lidar;
      const double values[] = {mount.x, mount.y, mount.yaw};
      file.add_row("robot_T_lidar", values);
    }
    return file;
  }

  fs::path folder_;
  RobotModel robot_;
  std::string set_;
  std::vector<double> wheel_stamps_s_;
  std::vector<std::int64_t> counts_;
  std::optional<std::array<std::int64_t, 4>> last_counts_;
  Columns rates_;
  std::vector<double> accelerations_;
  Columns poses_;
  std::vector<double> colour_stamps_s_;
  std::vector<double> depth_stamps_s_;
  std::optional<UcsdPictureCopies> colour_;
  std::optional<UcsdPictureCopies> depth_;
  bool has_plain_depth_ = false;
  std::int64_t frames_left_out_ = 0;
  LaserScan layout_;
  std::size_t beams_ = 0;
  bool states_mount_ = false;
  std::optional<RangeFile> ranges_;
  std::vector<float> column_;
  std::vector<double> scan_stamps_s_;
};

}  // namespace

std::unique_ptr<LogWriter> create_ucsd_log(const std::string& folder, const RobotModel& robot,
                                           int set) {
  return std::make_unique<UcsdWriter>(folder, robot, set);
}

}  // namespace loopstone
