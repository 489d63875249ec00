#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "formats/message_scan.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/messages/message_codec.hpp"

// A cloud's points, and the planar scan that is made of them.

namespace loopstone {
namespace {

constexpr int kBeams = 720;
constexpr double kBeamRad = 2.0 * kPi / kBeams;
constexpr double kNearestM = 0.05;
constexpr double kFarthestM = 200.0;
/// Names of the fields that hold a point's own time.
constexpr std::array<std::string_view, 5> kTimeFields{"time", "t", "timestamp", "time_stamp",
                                                      "offset_time"};

/// One field of the points of a cloud, read as a number.
class FieldReader {
 public:
  FieldReader(const msg::PointCloud2& cloud, const msg::PointField& field)
      : type_(field.datatype),
        offset_(field.offset),
        swap_(cloud.is_bigendian != (std::endian::native == std::endian::big)) {
    if (offset_ + size() > cloud.point_step) {
      throw MessageError(0, "the field '" + field.name + "' lies outside of the cloud's points");
    }
  }

  [[nodiscard]] double operator()(const std::uint8_t* point) const {
    using msg::PointField;
    switch (type_) {
      case PointField::kInt8:
        return static_cast<double>(load<std::int8_t>(point));
      case PointField::kUint8:
        return static_cast<double>(load<std::uint8_t>(point));
      case PointField::kInt16:
        return static_cast<double>(load<std::int16_t>(point));
      case PointField::kUint16:
        return static_cast<double>(load<std::uint16_t>(point));
      case PointField::kInt32:
        return static_cast<double>(load<std::int32_t>(point));
      case PointField::kUint32:
        return static_cast<double>(load<std::uint32_t>(point));
      case PointField::kFloat32:
        return static_cast<double>(load<float>(point));
      default:
        return load<double>(point);
    }
  }
  /// What its values are multiplied by to be seconds: integers count nanoseconds.
  [[nodiscard]] double seconds_per_unit() const {
    return type_ < msg::PointField::kFloat32 ? 1e-9 : 1.0;
  }

 private:
  [[nodiscard]] std::size_t size() const {
    constexpr std::array<std::size_t, 9> kSizes{0, 1, 1, 2, 2, 4, 4, 4, 8};
    if (type_ == 0 || type_ >= kSizes.size()) throw MessageError(0, "a field of unknown type");
    return kSizes[type_];
  }

  template <typename Number>
  [[nodiscard]] Number load(const std::uint8_t* point) const {
    std::array<std::uint8_t, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), point + offset_, sizeof(Number));
    if (swap_) std::ranges::reverse(bytes);
    return std::bit_cast<Number>(bytes);
  }

  std::uint8_t type_;
  std::size_t offset_;
  bool swap_;
};

std::optional<FieldReader> find_field(const msg::PointCloud2& cloud, std::string_view name) {
  for (const msg::PointField& field : cloud.fields) {
    if (field.name == name) return FieldReader(cloud, field);
  }
  return std::nullopt;
}

FieldReader needed_field(const msg::PointCloud2& cloud, std::string_view name) {
  if (const auto field = find_field(cloud, name)) return *field;
  throw MessageError(0, "the cloud's points have no " + std::string(name));
}

std::optional<FieldReader> time_field(const msg::PointCloud2& cloud) {
  for (const std::string_view name : kTimeFields) {
    if (const auto field = find_field(cloud, name)) return field;
  }
  return std::nullopt;
}

/// The nearest point of each beam.
struct Beams {
  std::vector<float> ranges_m = std::vector<float>(kBeams, std::numeric_limits<float>::quiet_NaN());
  std::vector<double> times_s = std::vector<double>(kBeams, 0.0);
};

/// Rows lie behind one another; of a single row many drivers do not state how long it is.
std::size_t row_step_of(const msg::PointCloud2& cloud) {
  const std::size_t packed = std::size_t{cloud.width} * cloud.point_step;
  if (cloud.height <= 1 || cloud.row_step == 0) return packed;
  if (cloud.row_step < packed) throw MessageError(0, "the rows of the cloud overlap");
  return cloud.row_step;
}

Beams gather(const msg::PointCloud2& cloud, const Pose3& base_T_laser, const HeightRange& heights) {
  const FieldReader x = needed_field(cloud, "x");
  const FieldReader y = needed_field(cloud, "y");
  const FieldReader z = needed_field(cloud, "z");
  const auto time = time_field(cloud);
  const Eigen::Matrix3d rotation = base_T_laser.rotation.toRotationMatrix();
  Beams beams;
  const std::size_t row_step = row_step_of(cloud);
  if (cloud.width == 0) return beams;
  for (std::size_t row = 0; row < cloud.height; ++row) {
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::size_t at = row * row_step + column * cloud.point_step;
      if (at + cloud.point_step > cloud.data.size()) return beams;
      const std::uint8_t* const point = cloud.data.data() + at;
      const Eigen::Vector3d seen = rotation * Eigen::Vector3d(x(point), y(point), z(point));
      const double height_m = seen.z() + base_T_laser.translation.z();
      if (!seen.allFinite() || height_m < heights.low_m || height_m > heights.high_m) continue;
      const double range_m = std::sqrt(seen.x() * seen.x() + seen.y() * seen.y());
      if (range_m < kNearestM || range_m > kFarthestM) continue;
      const double turn = (std::atan2(seen.y(), seen.x()) + kPi) / kBeamRad;
      const auto beam = static_cast<std::size_t>(std::clamp(turn, 0.0, kBeams - 1.0));
      if (static_cast<double>(beams.ranges_m[beam]) <= range_m) continue;
      beams.ranges_m[beam] = static_cast<float>(range_m);
      if (time) beams.times_s[beam] = (*time)(point)*time->seconds_per_unit();
    }
  }
  return beams;
}

/// How a spinning scanner goes over the beams.
struct Sweep {
  std::size_t first = 0;   ///< the earliest beam
  bool clockwise = false;  ///< later beams have smaller angles
  double per_beam_s = 0.0;
  double first_s = 0.0;
};

/// Nothing when the points have one time, or times that are no sweep.
std::optional<Sweep> sweep_of(const Beams& beams) {
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < kBeams; ++i) {
    if (!std::isnan(beams.ranges_m[i])) seen.push_back(i);
  }
  if (seen.size() < 20) return std::nullopt;
  std::vector<double> slopes;
  std::size_t earliest = seen.front();
  for (std::size_t k = 1; k < seen.size(); ++k) {
    const double step_s = beams.times_s[seen[k]] - beams.times_s[seen[k - 1]];
    if (!std::isfinite(step_s)) return std::nullopt;
    slopes.push_back(step_s / static_cast<double>(seen[k] - seen[k - 1]));
    if (beams.times_s[seen[k]] < beams.times_s[earliest]) earliest = seen[k];
  }
  const double per_beam_s = median_of(slopes);
  constexpr double kLongestSweepS = 1.0;
  const double sweep_s = std::abs(per_beam_s) * kBeams;
  if (sweep_s < 1e-4 || sweep_s > kLongestSweepS) return std::nullopt;
  return Sweep{.first = earliest,
               .clockwise = per_beam_s < 0.0,
               .per_beam_s = std::abs(per_beam_s),
               .first_s = beams.times_s[earliest]};
}

}  // namespace

LaserScan slice(const msg::PointCloud2& cloud, const Pose3& base_T_laser,
                const HeightRange& heights) {
  if (cloud.point_step == 0) throw MessageError(0, "the cloud's points have no size");
  const Beams beams = gather(cloud, base_T_laser, heights);
  LaserScan scan{.stamp = cloud.header.stamp,
                 .angle_min_rad = -kPi + 0.5 * kBeamRad,
                 .angle_increment_rad = kBeamRad,
                 .range_min_m = kNearestM,
                 .range_max_m = kFarthestM};
  scan.robot_T_lidar = Pose2{base_T_laser.translation.x(), base_T_laser.translation.y(), 0.0};
  const auto sweep = sweep_of(beams);
  if (!sweep) {
    scan.ranges_m = beams.ranges_m;
    return scan;
  }
  const auto direction = [&](std::size_t i) {
    return sweep->clockwise ? (sweep->first + kBeams - i) % kBeams : (sweep->first + i) % kBeams;
  };
  scan.angle_min_rad = -kPi + (static_cast<double>(sweep->first) + 0.5) * kBeamRad;
  scan.angle_increment_rad = sweep->clockwise ? -kBeamRad : kBeamRad;
  scan.time_increment_s = sweep->per_beam_s;
  for (std::size_t i = 0; i < kBeams; ++i) scan.ranges_m.push_back(beams.ranges_m[direction(i)]);
  // Times of the points count from the header's stamp, or are stamps themselves.
  constexpr double kStampS = 1e6;
  if (std::abs(sweep->first_s) < kStampS) {
    scan.stamp = scan.stamp + Duration::from_seconds(sweep->first_s);
  }
  return scan;
}

}  // namespace loopstone
