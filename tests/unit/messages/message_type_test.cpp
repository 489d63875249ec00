#include <gtest/gtest.h>

#include <algorithm>

#include "filled_message.hpp"
#include "known_messages.hpp"
#include "messages/hashes.hpp"

namespace loopstone {
namespace {

using test::for_each_message;

const test::KnownType& known_type(const std::string& name) {
  const auto at = std::ranges::find(test::kKnownTypes, name, &test::KnownType::name);
  if (at == test::kKnownTypes.end()) throw std::runtime_error("no known type " + name);
  return *at;
}

TEST(MessageTypes, HaveTheHashesOfBothGenerations) {
  std::size_t types = 0;
  for_each_message([&]<typename M>() {
    const test::KnownType& known = known_type(MessageType<M>::name());
    EXPECT_EQ(MessageType<M>::md5(), known.md5) << known.name;
    EXPECT_EQ(MessageType<M>::rihs01(), known.rihs01) << known.name;
    ++types;
  });
  EXPECT_EQ(types, test::kKnownTypes.size());
}

TEST(MessageTypes, HaveTheBytesThatOthersWrite) {
  for_each_message([]<typename M>() {
    const test::KnownType& known = known_type(MessageType<M>::name());
    const M message = test::counted_message<M>();
    EXPECT_EQ(md5_of(test::encoded(WireFormat::kRos1, message)), known.md5_of_ros1_bytes)
        << known.name;
    EXPECT_EQ(md5_of(test::encoded(WireFormat::kCdr, message)), known.md5_of_little_cdr)
        << known.name;
    EXPECT_EQ(md5_of(test::big_endian_cdr(message)), known.md5_of_big_cdr) << known.name;
  });
}

TEST(MessageTypes, ReadTheBytesThatOthersWrite) {
  std::size_t types = 0;
  for_each_message([&]<typename M>() {
    const auto at =
        std::ranges::find(test::kKnownBytes, MessageType<M>::name(), &test::KnownBytes::name);
    if (at == test::kKnownBytes.end()) return;
    ++types;
    const M message = test::counted_message<M>();
    EXPECT_EQ(test::hexadecimal(test::encoded(WireFormat::kRos1, message)), at->ros1) << at->name;
    EXPECT_EQ(test::hexadecimal(test::encoded(WireFormat::kCdr, message)), at->little_cdr)
        << at->name;
    EXPECT_EQ(test::hexadecimal(test::big_endian_cdr(message)), at->big_cdr) << at->name;
    const auto read = [&](WireFormat format, std::string_view digits) {
      std::string bytes;
      for (std::size_t i = 0; i < digits.size(); i += 2) {
        bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
      }
      return test::flat(test::decoded<M>(format, bytes));
    };
    EXPECT_EQ(read(WireFormat::kRos1, at->ros1), test::flat(message)) << at->name;
    EXPECT_EQ(read(WireFormat::kCdr, at->little_cdr), test::flat(message)) << at->name;
    EXPECT_EQ(read(WireFormat::kCdr, at->big_cdr), test::flat(message)) << at->name;
  });
  EXPECT_EQ(types, test::kKnownBytes.size());
}

TEST(MessageTypes, ReadTheirOwnDefinitionsAsCompiled) {
  for_each_message([]<typename M>() {
    using Type = MessageType<M>;
    EXPECT_TRUE(MessageDecoder<M>(WireFormat::kRos1,
                                  {DefinitionLanguage::kRos1Msg, Type::ros1_definition()})
                    .as_compiled())
        << Type::name();
    EXPECT_TRUE(
        MessageDecoder<M>(WireFormat::kCdr, {DefinitionLanguage::kRos2Msg, Type::ros2_definition()})
            .as_compiled())
        << Type::name();
    EXPECT_TRUE(MessageDecoder<M>(WireFormat::kCdr).as_compiled());
  });
}

// Source: rosbags 0.11.9, generate_msgdef().
TEST(MessageTypes, TellTheirDefinitions) {
  const std::string line = std::string(80, '=') + "\n";
  EXPECT_EQ(MessageType<msg::PointCloud2>::ros1_definition(),
            "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
            "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n" +
                line + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n" + line +
                "MSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\n"
                "uint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n"
                "string name\nuint32 offset\nuint8 datatype\nuint32 count\n");
  EXPECT_EQ(MessageType<msg::WheelTicks>::ros2_definition(),
            "std_msgs/Header header\nint64[4] counts\n" + line +
                "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + line +
                "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
  const std::string marker = MessageType<msg::Marker>::ros2_definition();
  EXPECT_TRUE(marker.starts_with("int32 ARROW=0\n"));
  EXPECT_NE(marker.find("int32 TRIANGLE_LIST=11\nint32 ARROW_STRIP=12\nint32 ADD=0\n"),
            marker.npos);
  EXPECT_NE(marker.find("MSG: visualization_msgs/UVCoordinate\nfloat32 u\nfloat32 v\n"),
            marker.npos);
  EXPECT_EQ(MessageType<msg::CameraInfo>::ros1_definition().find("float64[9] k"), marker.npos);
  EXPECT_EQ(MessageType<msg::CameraInfo>::ros2_definition().find("float64[9] K"), marker.npos);
}

TEST(MessageTypes, AreCalledInManyWays) {
  for (const char* name : {"sensor_msgs/LaserScan", "sensor_msgs/msg/LaserScan",
                           "sensor_msgs::msg::dds_::LaserScan_"}) {
    EXPECT_EQ(canonical_type(name), "sensor_msgs/LaserScan");
  }
  EXPECT_EQ(canonical_type("tf/tfMessage"), "tf2_msgs/TFMessage");
  EXPECT_EQ(canonical_type("foxglove.Scan"), "foxglove.Scan");
  EXPECT_EQ(canonical_type(""), "");
  EXPECT_EQ(ros2_type("sensor_msgs/LaserScan"), "sensor_msgs/msg/LaserScan");
}

}  // namespace
}  // namespace loopstone
