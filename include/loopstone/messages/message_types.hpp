#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"

// Messages of ROS 1 and ROS 2 that are read or written, as values. Names and fields are those of
// the common interfaces packages; both generations of ROS mean the same by them (ROS 1's `seq` of a
// header is not kept). Their bytes are message_codec.hpp's to know.

namespace loopstone::msg {

struct Header {
  Stamp stamp{};
  std::string frame_id{};
};

// geometry_msgs

struct Vector3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

struct Point {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;
};

struct Pose {
  Point position{};
  Quaternion orientation{};
};

struct PoseWithCovariance {
  Pose pose{};
  std::array<double, 36> covariance{};  ///< row-major: x, y, z, about x, about y, about z
};

struct Twist {
  Vector3 linear{};
  Vector3 angular{};
};

struct TwistWithCovariance {
  Twist twist{};
  std::array<double, 36> covariance{};
};

struct Transform {
  Vector3 translation{};
  Quaternion rotation{};
};

struct PoseStamped {
  Header header{};
  Pose pose{};
};

struct PoseWithCovarianceStamped {
  Header header{};
  PoseWithCovariance pose{};
};

struct PoseArray {
  Header header{};
  std::vector<Pose> poses{};
};

struct TransformStamped {
  Header header{};
  std::string child_frame_id{};
  Transform transform{};
};

// tf2_msgs (tf/tfMessage of ROS 1 has the same bytes)

struct TFMessage {
  std::vector<TransformStamped> transforms{};
};

// sensor_msgs

struct LaserScan {
  Header header{};
  float angle_min = 0.0F;
  float angle_max = 0.0F;
  float angle_increment = 0.0F;
  float time_increment = 0.0F;
  float scan_time = 0.0F;
  float range_min = 0.0F;
  float range_max = 0.0F;
  std::vector<float> ranges{};
  std::vector<float> intensities{};
};

struct LaserEcho {
  std::vector<float> echoes{};
};

struct MultiEchoLaserScan {
  Header header{};
  float angle_min = 0.0F;
  float angle_max = 0.0F;
  float angle_increment = 0.0F;
  float time_increment = 0.0F;
  float scan_time = 0.0F;
  float range_min = 0.0F;
  float range_max = 0.0F;
  std::vector<LaserEcho> ranges{};
  std::vector<LaserEcho> intensities{};
};

struct PointField {
  static constexpr std::uint8_t kInt8 = 1;
  static constexpr std::uint8_t kUint8 = 2;
  static constexpr std::uint8_t kInt16 = 3;
  static constexpr std::uint8_t kUint16 = 4;
  static constexpr std::uint8_t kInt32 = 5;
  static constexpr std::uint8_t kUint32 = 6;
  static constexpr std::uint8_t kFloat32 = 7;
  static constexpr std::uint8_t kFloat64 = 8;

  std::string name{};
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;
};

struct PointCloud2 {
  Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PointField> fields{};
  bool is_bigendian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  std::vector<std::uint8_t> data{};
  bool is_dense = false;
};

struct Imu {
  Header header{};
  Quaternion orientation{};
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity{};
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration{};
  std::array<double, 9> linear_acceleration_covariance{};
};

struct JointState {
  Header header{};
  std::vector<std::string> name{};
  std::vector<double> position{};
  std::vector<double> velocity{};
  std::vector<double> effort{};
};

struct Image {
  Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding{};
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data{};
};

struct CompressedImage {
  Header header{};
  std::string format{};
  std::vector<std::uint8_t> data{};
};

struct RegionOfInterest {
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  bool do_rectify = false;
};

struct CameraInfo {
  Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model{};
  std::vector<double> d{};
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest roi{};
};

// nav_msgs

struct Odometry {
  Header header{};
  std::string child_frame_id{};
  PoseWithCovariance pose{};
  TwistWithCovariance twist{};
};

struct MapMetaData {
  Stamp map_load_time{};
  float resolution = 0.0F;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  Pose origin{};
};

struct OccupancyGrid {
  Header header{};
  MapMetaData info{};
  std::vector<std::int8_t> data{};
};

struct Path {
  Header header{};
  std::vector<PoseStamped> poses{};
};

// std_msgs, rosgraph_msgs

struct String {
  std::string data{};
};

struct ColorRGBA {
  float r = 0.0F;
  float g = 0.0F;
  float b = 0.0F;
  float a = 0.0F;
};

struct Clock {
  Stamp clock{};
};

// visualization_msgs: the fields of both generations. ROS 2 has five more (texture_resource,
// texture, uv_coordinates, mesh_file), which are written empty.

struct Marker {
  static constexpr std::int32_t kSphere = 2;
  static constexpr std::int32_t kLineStrip = 4;
  static constexpr std::int32_t kLineList = 5;
  static constexpr std::int32_t kPoints = 8;
  static constexpr std::int32_t kText = 9;
  static constexpr std::int32_t kAdd = 0;
  static constexpr std::int32_t kDelete = 2;
  static constexpr std::int32_t kDeleteAll = 3;

  Header header{};
  std::string ns{};
  std::int32_t id = 0;
  std::int32_t type = 0;
  std::int32_t action = 0;
  Pose pose{};
  Vector3 scale{};
  ColorRGBA color{};
  Duration lifetime{};
  bool frame_locked = false;
  std::vector<Point> points{};
  std::vector<ColorRGBA> colors{};
  std::string text{};
  std::string mesh_resource{};
  bool mesh_use_embedded_materials = false;
};

struct MarkerArray {
  std::vector<Marker> markers{};
};

// diagnostic_msgs

struct KeyValue {
  std::string key{};
  std::string value{};
};

struct DiagnosticStatus {
  static constexpr std::uint8_t kOk = 0;
  static constexpr std::uint8_t kWarn = 1;
  static constexpr std::uint8_t kError = 2;

  std::uint8_t level = kOk;
  std::string name{};
  std::string message{};
  std::string hardware_id{};
  std::vector<KeyValue> values{};
};

struct DiagnosticArray {
  Header header{};
  std::vector<DiagnosticStatus> status{};
};

// loopstone_msgs: what the common packages have no message for

/// Counts of the encoders [front right, front left, rear right, rear left], as WheelTicks has them.
struct WheelTicks {
  Header header{};
  std::array<std::int64_t, 4> counts{};
};

/// Some tiles of an occupancy map, such as those that changed: `size` x `size` cells each.
struct MapTiles {
  static constexpr std::uint8_t kUnknown = 255;

  double resolution = 0.0;            ///< side of a cell [m]
  std::uint32_t size = 0;             ///< cells a side
  bool whole = false;                 ///< all tiles that were told before are no more
  std::vector<std::int32_t> ids{};    ///< column, row of each: its lower left corner lies at
                                      ///< (column * size * resolution, row * size * resolution)
  std::vector<std::uint8_t> cells{};  ///< of each size * size, row by row from the lower left one:
                                      ///< occupied in percent, or kUnknown
};

/// The nodes of a path, of which the last ones are told anew.
struct Trajectory {
  std::uint32_t first = 0;     ///< the first one that is told; from there on all are replaced
  std::uint32_t count = 0;     ///< there are then
  std::vector<double> t{};     ///< [s], one a node that is told
  std::vector<float> poses{};  ///< x, y, yaw of each
  std::vector<float> sigma{};  ///< larger half-axis of the position's covariance [m]
  std::vector<std::uint32_t> submaps{};  ///< which each belongs to
  std::vector<std::uint32_t> drives{};
};

}  // namespace loopstone::msg
