#pragma once

struct ddsi_sertype;  // NOLINT(readability-identifier-naming): Cyclone's own name

namespace loopstone::app {

/// A type of DDS whose samples are the bytes of messages as they are on the wire, with their
/// encapsulation: Cyclone writes and takes a std::string, and neither knows nor checks what it
/// holds. Types have no keys.
/// \param type_name  as DDS knows it: "sensor_msgs::msg::dds_::LaserScan_"
/// The caller owns it, until a topic is made of it.
[[nodiscard]] ddsi_sertype* make_raw_type(const char* type_name);

}  // namespace loopstone::app
