#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/messages/message_types.hpp"

// The fields of every message, once. From here follow its bytes in both serialisations, the text of
// its definition, ROS 1's MD5 and ROS 2's RIHS01 hash, so the order, the names and the types are
// part of the description. Source: common_msgs of ROS 1 Noetic, common_interfaces of ROS 2 Jazzy.

namespace loopstone {

/// How a field is called in either generation of ROS; an empty name: that one does not have it.
struct FieldName {
  // NOLINTNEXTLINE(google-explicit-constructor): a description reads v("x", m.x).
  constexpr FieldName(const char* both) : ros1(both), ros2(both) {}
  constexpr FieldName(std::string_view in_ros1, std::string_view in_ros2)
      : ros1(in_ros1), ros2(in_ros2) {}

  std::string_view ros1;
  std::string_view ros2;
  bool byte = false;  ///< a uint8_t that the definition calls byte
};

constexpr FieldName only_ros1(std::string_view name) { return {name, {}}; }
constexpr FieldName only_ros2(std::string_view name) { return {{}, name}; }
constexpr FieldName as_byte(const char* name) {
  FieldName field(name);
  field.byte = true;
  return field;
}

/// A constant of a definition: "INT8=1" and its type in either generation.
struct MessageConstant {
  std::string_view ros1_type;
  std::string_view ros2_type;
  std::string_view text;
};

inline std::vector<MessageConstant> constants(std::string_view ros1_type,
                                              std::string_view ros2_type,
                                              std::initializer_list<std::string_view> texts) {
  std::vector<MessageConstant> all;
  for (const std::string_view text : texts) all.push_back({ros1_type, ros2_type, text});
  return all;
}

/// Of a message M: kName, visit(v, message), which calls v(FieldName, value) for each field in its
/// order, and constants() where it has some. A field that messages do not keep is a local value: it
/// is written at its default and read into nothing.
template <typename M>
struct Fields;

template <>
struct Fields<msg::Header> {
  static constexpr std::string_view kName = "std_msgs/Header";
  static void visit(auto& v, auto& m) {
    std::uint32_t seq = 0;
    v(only_ros1("seq"), seq);
    v("stamp", m.stamp);
    v("frame_id", m.frame_id);
  }
};

template <>
struct Fields<msg::String> {
  static constexpr std::string_view kName = "std_msgs/String";
  static void visit(auto& v, auto& m) { v("data", m.data); }
};

template <>
struct Fields<msg::ColorRGBA> {
  static constexpr std::string_view kName = "std_msgs/ColorRGBA";
  static void visit(auto& v, auto& m) {
    v("r", m.r);
    v("g", m.g);
    v("b", m.b);
    v("a", m.a);
  }
};

template <>
struct Fields<msg::Clock> {
  static constexpr std::string_view kName = "rosgraph_msgs/Clock";
  static void visit(auto& v, auto& m) { v("clock", m.clock); }
};

// geometry_msgs

template <>
struct Fields<msg::Vector3> {
  static constexpr std::string_view kName = "geometry_msgs/Vector3";
  static void visit(auto& v, auto& m) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

template <>
struct Fields<msg::Point> {
  static constexpr std::string_view kName = "geometry_msgs/Point";
  static void visit(auto& v, auto& m) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
  }
};

template <>
struct Fields<msg::Quaternion> {
  static constexpr std::string_view kName = "geometry_msgs/Quaternion";
  static void visit(auto& v, auto& m) {
    v("x", m.x);
    v("y", m.y);
    v("z", m.z);
    v("w", m.w);
  }
};

template <>
struct Fields<msg::Pose> {
  static constexpr std::string_view kName = "geometry_msgs/Pose";
  static void visit(auto& v, auto& m) {
    v("position", m.position);
    v("orientation", m.orientation);
  }
};

template <>
struct Fields<msg::PoseWithCovariance> {
  static constexpr std::string_view kName = "geometry_msgs/PoseWithCovariance";
  static void visit(auto& v, auto& m) {
    v("pose", m.pose);
    v("covariance", m.covariance);
  }
};

template <>
struct Fields<msg::Twist> {
  static constexpr std::string_view kName = "geometry_msgs/Twist";
  static void visit(auto& v, auto& m) {
    v("linear", m.linear);
    v("angular", m.angular);
  }
};

template <>
struct Fields<msg::TwistWithCovariance> {
  static constexpr std::string_view kName = "geometry_msgs/TwistWithCovariance";
  static void visit(auto& v, auto& m) {
    v("twist", m.twist);
    v("covariance", m.covariance);
  }
};

template <>
struct Fields<msg::Transform> {
  static constexpr std::string_view kName = "geometry_msgs/Transform";
  static void visit(auto& v, auto& m) {
    v("translation", m.translation);
    v("rotation", m.rotation);
  }
};

template <>
struct Fields<msg::PoseStamped> {
  static constexpr std::string_view kName = "geometry_msgs/PoseStamped";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("pose", m.pose);
  }
};

template <>
struct Fields<msg::PoseWithCovarianceStamped> {
  static constexpr std::string_view kName = "geometry_msgs/PoseWithCovarianceStamped";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("pose", m.pose);
  }
};

template <>
struct Fields<msg::PoseArray> {
  static constexpr std::string_view kName = "geometry_msgs/PoseArray";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("poses", m.poses);
  }
};

template <>
struct Fields<msg::TransformStamped> {
  static constexpr std::string_view kName = "geometry_msgs/TransformStamped";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("child_frame_id", m.child_frame_id);
    v("transform", m.transform);
  }
};

template <>
struct Fields<msg::TFMessage> {
  static constexpr std::string_view kName = "tf2_msgs/TFMessage";
  static void visit(auto& v, auto& m) { v("transforms", m.transforms); }
};

// sensor_msgs

/// The fields that scans of one and of several echoes have in common.
void visit_scan(auto& v, auto& m) {
  v("header", m.header);
  v("angle_min", m.angle_min);
  v("angle_max", m.angle_max);
  v("angle_increment", m.angle_increment);
  v("time_increment", m.time_increment);
  v("scan_time", m.scan_time);
  v("range_min", m.range_min);
  v("range_max", m.range_max);
  v("ranges", m.ranges);
  v("intensities", m.intensities);
}

template <>
struct Fields<msg::LaserScan> {
  static constexpr std::string_view kName = "sensor_msgs/LaserScan";
  static void visit(auto& v, auto& m) { visit_scan(v, m); }
};

template <>
struct Fields<msg::LaserEcho> {
  static constexpr std::string_view kName = "sensor_msgs/LaserEcho";
  static void visit(auto& v, auto& m) { v("echoes", m.echoes); }
};

template <>
struct Fields<msg::MultiEchoLaserScan> {
  static constexpr std::string_view kName = "sensor_msgs/MultiEchoLaserScan";
  static void visit(auto& v, auto& m) { visit_scan(v, m); }
};

template <>
struct Fields<msg::PointField> {
  static constexpr std::string_view kName = "sensor_msgs/PointField";
  static std::vector<MessageConstant> constants() {
    return loopstone::constants("uint8", "uint8",
                                {"INT8=1", "UINT8=2", "INT16=3", "UINT16=4", "INT32=5", "UINT32=6",
                                 "FLOAT32=7", "FLOAT64=8"});
  }
  static void visit(auto& v, auto& m) {
    v("name", m.name);
    v("offset", m.offset);
    v("datatype", m.datatype);
    v("count", m.count);
  }
};

template <>
struct Fields<msg::PointCloud2> {
  static constexpr std::string_view kName = "sensor_msgs/PointCloud2";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("fields", m.fields);
    v("is_bigendian", m.is_bigendian);
    v("point_step", m.point_step);
    v("row_step", m.row_step);
    v("data", m.data);
    v("is_dense", m.is_dense);
  }
};

template <>
struct Fields<msg::Imu> {
  static constexpr std::string_view kName = "sensor_msgs/Imu";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("orientation", m.orientation);
    v("orientation_covariance", m.orientation_covariance);
    v("angular_velocity", m.angular_velocity);
    v("angular_velocity_covariance", m.angular_velocity_covariance);
    v("linear_acceleration", m.linear_acceleration);
    v("linear_acceleration_covariance", m.linear_acceleration_covariance);
  }
};

template <>
struct Fields<msg::JointState> {
  static constexpr std::string_view kName = "sensor_msgs/JointState";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("name", m.name);
    v("position", m.position);
    v("velocity", m.velocity);
    v("effort", m.effort);
  }
};

template <>
struct Fields<msg::Image> {
  static constexpr std::string_view kName = "sensor_msgs/Image";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("encoding", m.encoding);
    v("is_bigendian", m.is_bigendian);
    v("step", m.step);
    v("data", m.data);
  }
};

template <>
struct Fields<msg::CompressedImage> {
  static constexpr std::string_view kName = "sensor_msgs/CompressedImage";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("format", m.format);
    v("data", m.data);
  }
};

template <>
struct Fields<msg::RegionOfInterest> {
  static constexpr std::string_view kName = "sensor_msgs/RegionOfInterest";
  static void visit(auto& v, auto& m) {
    v("x_offset", m.x_offset);
    v("y_offset", m.y_offset);
    v("height", m.height);
    v("width", m.width);
    v("do_rectify", m.do_rectify);
  }
};

template <>
struct Fields<msg::CameraInfo> {
  static constexpr std::string_view kName = "sensor_msgs/CameraInfo";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("distortion_model", m.distortion_model);
    v(FieldName("D", "d"), m.d);
    v(FieldName("K", "k"), m.k);
    v(FieldName("R", "r"), m.r);
    v(FieldName("P", "p"), m.p);
    v("binning_x", m.binning_x);
    v("binning_y", m.binning_y);
    v("roi", m.roi);
  }
};

// nav_msgs

template <>
struct Fields<msg::Odometry> {
  static constexpr std::string_view kName = "nav_msgs/Odometry";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("child_frame_id", m.child_frame_id);
    v("pose", m.pose);
    v("twist", m.twist);
  }
};

template <>
struct Fields<msg::MapMetaData> {
  static constexpr std::string_view kName = "nav_msgs/MapMetaData";
  static void visit(auto& v, auto& m) {
    v("map_load_time", m.map_load_time);
    v("resolution", m.resolution);
    v("width", m.width);
    v("height", m.height);
    v("origin", m.origin);
  }
};

template <>
struct Fields<msg::OccupancyGrid> {
  static constexpr std::string_view kName = "nav_msgs/OccupancyGrid";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("info", m.info);
    v("data", m.data);
  }
};

template <>
struct Fields<msg::Path> {
  static constexpr std::string_view kName = "nav_msgs/Path";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("poses", m.poses);
  }
};

// visualization_msgs

/// Parts of ROS 2's Marker that nobody sets.
struct UvCoordinate {
  float u = 0.0F;
  float v = 0.0F;
};
struct MeshFile {
  std::string filename{};
  std::vector<std::uint8_t> data{};
};

template <>
struct Fields<UvCoordinate> {
  static constexpr std::string_view kName = "visualization_msgs/UVCoordinate";
  static void visit(auto& v, auto& m) {
    v("u", m.u);
    v("v", m.v);
  }
};

template <>
struct Fields<MeshFile> {
  static constexpr std::string_view kName = "visualization_msgs/MeshFile";
  static void visit(auto& v, auto& m) {
    v("filename", m.filename);
    v("data", m.data);
  }
};

template <>
struct Fields<msg::Marker> {
  static constexpr std::string_view kName = "visualization_msgs/Marker";
  static std::vector<MessageConstant> constants() {
    auto all = loopstone::constants(
        "uint8", "int32",
        {"ARROW=0", "CUBE=1", "SPHERE=2", "CYLINDER=3", "LINE_STRIP=4", "LINE_LIST=5",
         "CUBE_LIST=6", "SPHERE_LIST=7", "POINTS=8", "TEXT_VIEW_FACING=9", "MESH_RESOURCE=10",
         "TRIANGLE_LIST=11", "ADD=0", "MODIFY=0", "DELETE=2", "DELETEALL=3"});
    all.insert(all.begin() + 12, {"", "int32", "ARROW_STRIP=12"});
    return all;
  }
  static void visit(auto& v, auto& m) {
    std::string texture_resource;
    msg::CompressedImage texture;
    std::vector<UvCoordinate> uv_coordinates;
    MeshFile mesh_file;
    v("header", m.header);
    v("ns", m.ns);
    v("id", m.id);
    v("type", m.type);
    v("action", m.action);
    v("pose", m.pose);
    v("scale", m.scale);
    v("color", m.color);
    v("lifetime", m.lifetime);
    v("frame_locked", m.frame_locked);
    v("points", m.points);
    v("colors", m.colors);
    v(only_ros2("texture_resource"), texture_resource);
    v(only_ros2("texture"), texture);
    v(only_ros2("uv_coordinates"), uv_coordinates);
    v("text", m.text);
    v("mesh_resource", m.mesh_resource);
    v(only_ros2("mesh_file"), mesh_file);
    v("mesh_use_embedded_materials", m.mesh_use_embedded_materials);
  }
};

template <>
struct Fields<msg::MarkerArray> {
  static constexpr std::string_view kName = "visualization_msgs/MarkerArray";
  static void visit(auto& v, auto& m) { v("markers", m.markers); }
};

// diagnostic_msgs

template <>
struct Fields<msg::KeyValue> {
  static constexpr std::string_view kName = "diagnostic_msgs/KeyValue";
  static void visit(auto& v, auto& m) {
    v("key", m.key);
    v("value", m.value);
  }
};

template <>
struct Fields<msg::DiagnosticStatus> {
  static constexpr std::string_view kName = "diagnostic_msgs/DiagnosticStatus";
  static std::vector<MessageConstant> constants() {
    return loopstone::constants("byte", "byte", {"OK=0", "WARN=1", "ERROR=2", "STALE=3"});
  }
  static void visit(auto& v, auto& m) {
    v(as_byte("level"), m.level);
    v("name", m.name);
    v("message", m.message);
    v("hardware_id", m.hardware_id);
    v("values", m.values);
  }
};

template <>
struct Fields<msg::DiagnosticArray> {
  static constexpr std::string_view kName = "diagnostic_msgs/DiagnosticArray";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("status", m.status);
  }
};

// loopstone_msgs

template <>
struct Fields<msg::WheelTicks> {
  static constexpr std::string_view kName = "loopstone_msgs/WheelTicks";
  static void visit(auto& v, auto& m) {
    v("header", m.header);
    v("counts", m.counts);
  }
};

template <>
struct Fields<msg::MapTiles> {
  static constexpr std::string_view kName = "loopstone_msgs/MapTiles";
  static void visit(auto& v, auto& m) {
    v("resolution", m.resolution);
    v("size", m.size);
    v("whole", m.whole);
    v("ids", m.ids);
    v("cells", m.cells);
  }
};

template <>
struct Fields<msg::Trajectory> {
  static constexpr std::string_view kName = "loopstone_msgs/Trajectory";
  static void visit(auto& v, auto& m) {
    v("first", m.first);
    v("count", m.count);
    v("t", m.t);
    v("poses", m.poses);
    v("sigma", m.sigma);
    v("submaps", m.submaps);
    v("drives", m.drives);
  }
};

}  // namespace loopstone
