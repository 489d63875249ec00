#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "formats/byte_source.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

// MRPT's rawlog: one serialised object after the other, little endian.
//   object: 0x80 + length of the name, name, 1 byte version, fields, 0x88
//           before MRPT 0.5.5: length, 0 0 0, name, 4 bytes version, fields, and no end
// Names are of the class, since MRPT 2 with its namespaces. Nothing tells an object's size: one of
// an unknown class is passed over by looking for the next beginning that can be one.

/// A sensor's place in space: robot_T_sensor.
struct RawlogPose3 {
  std::array<double, 3> position_m{};
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row
};

/// CObservation2DRangeScan.
struct RawlogScan {
  std::optional<Stamp> stamp{};
  std::string label{};
  double aperture_rad = 0.0;
  bool right_to_left = true;
  double max_range_m = 0.0;
  RawlogPose3 robot_T_lidar{};
  double pitch_change_rad = 0.0;  ///< while it swept
  std::vector<float> ranges_m{};
  std::vector<bool> valid{};
};

/// CObservationOdometry.
struct RawlogOdometry {
  std::optional<Stamp> stamp{};
  std::string label{};
  Pose2 odom_T_robot{};
};

/// CActionRobotMovement2D: how the robot moved since the last one.
struct RawlogMotion {
  std::optional<Stamp> stamp{};
  Pose2 increment{};
  bool is_odometry = true;  ///< else it is an estimate, by scan matching
};

/// An object of another class, or of an unknown version.
struct RawlogOther {
  std::string name{};  ///< of the class, without namespaces
};

/// Bytes that are not what they should be.
struct RawlogBroken {
  std::string reason{};
  bool is_scan = false;
};

struct RawlogObject {
  std::int64_t offset = 0;  ///< in the unpacked file
  std::variant<RawlogScan, RawlogOdometry, RawlogMotion, RawlogOther, RawlogBroken> content{};
};

/// Whether bytes can be the beginning of a rawlog's object; as many as there are, up to its name's
/// end.
[[nodiscard]] bool begins_as_rawlog(std::string_view head);

/// The objects of a rawlog, in the order of the file; what sensory frames and collections of
/// actions hold comes one by one. Memory is bounded by the largest scan, whatever the bytes say.
class RawlogObjects {
 public:
  static constexpr std::uint32_t kMostBeams = 100'000;

  explicit RawlogObjects(std::unique_ptr<ByteSource> source);

  /// Nothing at the end. Throws DataError when the file can't be unpacked any further, after all
  /// that stands before.
  [[nodiscard]] std::optional<RawlogObject> next();
  [[nodiscard]] const ByteSource& source() const { return *source_; }
  /// Unpacked bytes that were passed.
  [[nodiscard]] std::int64_t offset() const { return offset_; }

 private:
  class Fields;
  struct Head;

  [[nodiscard]] bool fill(std::size_t bytes);
  [[nodiscard]] std::size_t held() const { return end_ - begin_; }
  [[nodiscard]] std::string_view ahead() const { return {buffer_.data() + begin_, held()}; }
  void pass(std::size_t bytes);
  [[nodiscard]] bool at_end_of_containers();
  [[nodiscard]] bool find_next();
  /// What next() gives at the end; throws when that came too early.
  [[nodiscard]] std::optional<RawlogObject> ended() const;
  [[nodiscard]] RawlogObject read_object(const Head& head);

  std::unique_ptr<ByteSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::int64_t offset_ = 0;  ///< of begin_
  bool source_ended_ = false;
  std::exception_ptr failure_{};  ///< of the source: told after what was read before it
  bool is_lost_ = false;          ///< the next object has to be looked for
  struct Container {
    std::uint32_t left = 0;
    bool has_end = true;
    std::optional<Stamp> stamp{};  ///< of all that it holds
  };
  std::vector<Container> containers_{};
};

}  // namespace loopstone
