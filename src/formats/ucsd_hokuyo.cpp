#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "formats/ucsd_sensors.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kMostBeams = 100'000;

double read_number(const NpzFile& file, const std::string& path, const std::string& key) {
  const NpyArray array = file.read(key);
  if (array.values.size() != 1 || !std::isfinite(array.values[0])) {
    throw DataError({path}, key + " is " + shape_text(array.shape) +
                                (array.values.size() == 1 ? " that is not finite" : "") +
                                ", a finite number was expected");
  }
  return array.values[0];
}

std::optional<Pose2> read_mount(const NpzFile& file, const std::string& path) {
  if (!file.has("robot_T_lidar")) return std::nullopt;
  const NpyArray array = file.read("robot_T_lidar");
  const auto& v = array.values;
  if (v.size() != 3 || !std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) {
    throw DataError({path}, "robot_T_lidar must be three finite numbers: x, y, yaw");
  }
  if (std::max(std::abs(v[0]), std::abs(v[1])) > kFarthestMountM) {
    throw DataError({path},
                    "robot_T_lidar is more than 100 m from the robot's centre: no mount is");
  }
  return Pose2{v[0], v[1], wrap_angle(v[2])};
}

/// The ranges of one scan after another.
class Ranges {
 public:
  Ranges(const NpzFile& file, const std::string& path, std::int64_t scans)
      : reader_(file.open("ranges")) {
    const NpyHeader& header = reader_.header();
    const auto& shape = header.shape;
    const bool columns = shape.size() == 2 && shape[1] == scans;
    const bool rows = !columns && shape.size() == 2 && shape[0] == scans;
    if (!columns && !rows) {
      throw DataError({path}, "ranges is " + shape_text(shape) + ", but there are " +
                                  std::to_string(scans) +
                                  " stamps: one column for each was expected");
    }
    beams_ = columns ? shape[0] : shape[1];
    if (beams_ == 0 && scans > 0) throw DataError({path}, "the scans have no beams");
    if (beams_ > kMostBeams) {
      throw DataError({path}, "ranges is " + shape_text(shape) + ": too many beams for a scanner");
    }
    is_sequential_ = columns == header.fortran_order;
    scans_ = scans;
    if (!is_sequential_) hold(file);
  }

  std::vector<float> scan(std::int64_t index) {
    std::vector<float> ranges_m(static_cast<std::size_t>(beams_));
    if (is_sequential_) {
      for (; next_ <= index; ++next_) reader_.read(std::span(ranges_m));
      return ranges_m;
    }
    for (std::size_t beam = 0; beam < ranges_m.size(); ++beam) {
      ranges_m[beam] =
          held_[beam * static_cast<std::size_t>(scans_) + static_cast<std::size_t>(index)];
    }
    return ranges_m;
  }

 private:
  /// The order of the file is beam by beam.
  void hold(const NpzFile& file) {
    const auto count = static_cast<std::uint64_t>(beams_ * scans_);
    file.require_memory("ranges", count * sizeof(float));
    held_.reserve(static_cast<std::size_t>(count));
    for (std::int64_t beam = 0; beam < beams_; ++beam) {
      const std::size_t begin = held_.size();
      held_.resize(begin + static_cast<std::size_t>(scans_));
      reader_.read(std::span(held_).subspan(begin));
    }
  }

  NpyReader reader_;
  std::int64_t beams_ = 0;
  std::int64_t scans_ = 0;
  std::int64_t next_ = 0;
  bool is_sequential_ = false;
  std::vector<float> held_{};
};

/// Below range_min or not a number: bad. From range_max on: nothing within reach.
void translate(std::vector<float>& ranges_m, double range_min_m, double range_max_m) {
  const auto lowest_m = static_cast<float>(range_min_m);
  const auto highest_m = static_cast<float>(range_max_m);
  for (float& range_m : ranges_m) {
    if (!(range_m >= lowest_m) || range_m <= 0.0F) {
      range_m = std::numeric_limits<float>::quiet_NaN();
    } else if (range_m >= highest_m) {
      range_m = std::numeric_limits<float>::infinity();
    }
  }
}

}  // namespace

UcsdChannel open_ucsd_hokuyo(const NpzFile& file, const std::string& path) {
  UcsdChannel channel{path};
  const std::vector<double> seconds = read_ucsd_stamps(file, path);
  LaserScan model;
  model.angle_min_rad = read_number(file, path, "angle_min");
  model.angle_increment_rad = read_number(file, path, "angle_increment");
  model.range_min_m = file.has("range_min") ? read_number(file, path, "range_min") : 0.1;
  model.range_max_m = file.has("range_max") ? read_number(file, path, "range_max") : 30.0;
  if (file.has("time_increment")) {
    model.time_increment_s = read_number(file, path, "time_increment");
  }
  model.robot_T_lidar = read_mount(file, path);
  if (!(model.range_max_m > std::max(0.0, model.range_min_m))) {
    throw DataError({path}, "range_max must be larger than range_min and 0");
  }
  if (!file.has("range_min") || !file.has("range_max")) {
    channel.notes.emplace_back("the file does not state range_min and range_max: 0.1 and 30 m");
  }
  const auto ranges =
      std::make_shared<Ranges>(file, path, static_cast<std::int64_t>(seconds.size()));
  channel.kept = keep_increasing(seconds);
  channel.make = [model, ranges](Stamp stamp, std::int64_t index) {
    LaserScan scan = model;
    scan.stamp = stamp;
    scan.ranges_m = ranges->scan(index);
    translate(scan.ranges_m, model.range_min_m, model.range_max_m);
    return scan;
  };
  return channel;
}

}  // namespace loopstone
