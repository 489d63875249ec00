#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "filled_message.hpp"

namespace loopstone {
namespace {

using test::decoded;
using test::encoded;
using test::flat;

const std::string kLine = std::string(80, '=') + "\n";
const std::string kTime = kLine + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const std::string kHeader =
    kLine + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + kTime;

MessageDefinition ros1(const std::string& text) { return {DefinitionLanguage::kRos1Msg, text}; }
MessageDefinition ros2(const std::string& text) { return {DefinitionLanguage::kRos2Msg, text}; }

/// Of the packed serialisation, by hand.
template <typename... T>
std::string packed(const T&... values) {
  std::string bytes;
  WireWriter out(WireFormat::kRos1, bytes);
  const FieldWriter writer{out};
  (writer.write(values), ...);
  return bytes;
}
template <typename... T>
std::string cdr(const T&... values) {
  std::string bytes;
  WireWriter out(WireFormat::kCdr, bytes);
  const FieldWriter writer{out};
  (writer.write(values), ...);
  return bytes;
}

TEST(MessageDefinitions, ThatSayTheSameInOtherWordsAreReadAsCompiled) {
  const std::string text =
      "# A scan\r\n@ignored\n\nHeader   header # of the first ray\nfloat32 angle_min\n"
      "float32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\nfloat32 scan_time\n"
      "float32 range_min\nfloat32 range_max\nfloat32 NONE = -1.0\nstring NOTE=a # is no comment\n"
      "float32[] ranges\nfloat32[] intensities\n" +
      kLine + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
  EXPECT_TRUE(MessageDecoder<msg::LaserScan>(WireFormat::kRos1, ros1(text)).as_compiled());
  // Bounds and defaults do not change the bytes; the message may be named, too.
  EXPECT_TRUE(
      MessageDecoder<msg::JointState>(
          WireFormat::kCdr, ros2("MSG: sensor_msgs/msg/JointState\nstd_msgs/msg/Header header\n"
                                 "string<=10[<=3] name [\"a\", 'b']\nfloat64[<=5] position\n"
                                 "float64[] velocity [1.0, 2.0]\nfloat64[] effort\n" +
                                 kHeader))
          .as_compiled());
  EXPECT_TRUE(
      MessageDecoder<msg::DiagnosticStatus>(
          WireFormat::kCdr, ros2("char level 1\nstring name \"a = b # c\"\nstring message\n"
                                 "string hardware_id\nKeyValue[] values\n" +
                                 kLine + "MSG: diagnostic_msgs/KeyValue\nstring key\nstring value"))
          .as_compiled());
}

TEST(MessageDefinitions, FieldsAreFoundByTheirNames) {
  const auto definition = ros2(
      "float32[<=4] ranges\nuint8 more\nfloat64 range_max\nuint16 angle_min\n"
      "string[] notes\nstd_msgs/Header header\nstd_msgs/Header[2] others\n" +
      kHeader);
  const MessageDecoder<msg::LaserScan> decoder(WireFormat::kCdr, definition);
  EXPECT_FALSE(decoder.as_compiled());
  const msg::Header header{Stamp{3'000'000'004}, "laser"};
  const std::string bytes =
      cdr(std::vector<float>{1.0F, 2.5F}, std::uint8_t{9}, 12.5, std::uint16_t{3},
          std::vector<std::string>{"a", "b"}, header, msg::Header{}, msg::Header{{}, "x"});
  msg::LaserScan scan;
  scan.range_min = 7.0F;
  scan.intensities = {1.0F};
  decoder.decode(bytes, scan);
  EXPECT_EQ(scan.ranges, (std::vector<float>{1.0F, 2.5F}));
  EXPECT_EQ(scan.range_max, 12.5F);
  EXPECT_EQ(scan.angle_min, 3.0F);
  EXPECT_EQ(scan.header.stamp, header.stamp);
  EXPECT_EQ(scan.header.frame_id, "laser");
  EXPECT_EQ(scan.range_min, 0.0F) << "what the definition lacks has its default";
  EXPECT_TRUE(scan.intensities.empty());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(decoder.decode(std::string_view(bytes).substr(0, size), scan), MessageError);
  }
}

TEST(MessageDefinitions, FieldsOfTheSameTypesInAnotherOrderAreNoCompiledLayout) {
  const MessageDecoder<msg::Vector3> decoder(WireFormat::kRos1,
                                             ros1("float64 z\nfloat64 y\nfloat64 x\n"));
  EXPECT_FALSE(decoder.as_compiled());
  msg::Vector3 read;
  decoder.decode(packed(3.0, 2.0, 1.0), read);
  EXPECT_EQ(flat(read), flat(msg::Vector3{1.0, 2.0, 3.0}));
}

TEST(MessageDefinitions, RangesMayBeDoubles) {
  const MessageDecoder<msg::LaserEcho> decoder(WireFormat::kCdr, ros2("float64[] echoes\n"));
  msg::LaserEcho echo;
  decoder.decode(cdr(std::vector<double>{1.5, 2.5, 1e300}), echo);
  EXPECT_EQ(echo.echoes, (std::vector<float>{1.5F, 2.5F, std::numeric_limits<float>::infinity()}));
}

TEST(MessageDefinitions, NumbersBecomeTheNearestThatFit) {
  const auto height_of = [](const std::string& type, auto value) {
    return decoded<msg::RegionOfInterest>(WireFormat::kRos1, packed(value),
                                          ros1(type + " height\n"))
        .height;
  };
  EXPECT_EQ(height_of("int8", std::int8_t{-3}), 0U);
  EXPECT_EQ(height_of("int64", std::int64_t{1} << 40), 0xffffffffU);
  EXPECT_EQ(height_of("uint64", std::uint64_t{77}), 77U);
  EXPECT_EQ(height_of("float64", 5.9), 5U);
  EXPECT_EQ(height_of("float64", -1e300), 0U);
  EXPECT_EQ(height_of("float32", 1e30F), 0xffffffffU);
  EXPECT_EQ(height_of("float64", std::nan("")), 0U);
  EXPECT_EQ(height_of("bool", true), 1U);
  const auto ticks = [](double value) {
    return decoded<msg::WheelTicks>(WireFormat::kRos1, packed(value), ros1("float64[1] counts\n"))
        .counts[0];
  };
  EXPECT_EQ(ticks(9.3e18), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(ticks(-9.3e18), std::numeric_limits<std::int64_t>::min());
}

TEST(MessageDefinitions, ArraysMayBeLongerOrShorter) {
  const auto counts_of = [](const std::string& text, const std::string& bytes) {
    return decoded<msg::WheelTicks>(WireFormat::kRos1, bytes, ros1(text)).counts;
  };
  using Counts = std::array<std::int64_t, 4>;
  EXPECT_EQ(counts_of("int32[] counts", packed(std::vector<int>{1, 2})), (Counts{1, 2, 0, 0}));
  EXPECT_EQ(counts_of("int16[5] counts\n", packed(std::array<std::int16_t, 5>{1, 2, 3, 4, 5})),
            (Counts{1, 2, 3, 4}));
}

// Foxy's Marker ends without the five fields that came later.
TEST(MessageDefinitions, OlderMarkersAreRead) {
  std::string text = MessageType<msg::Marker>::ros2_definition();
  for (const std::string field :
       {"string texture_resource\n", "sensor_msgs/CompressedImage texture\n",
        "visualization_msgs/UVCoordinate[] uv_coordinates\n",
        "visualization_msgs/MeshFile mesh_file\n"}) {
    ASSERT_NE(text.find(field), text.npos);
    text.erase(text.find(field), field.size());
  }
  const MessageDecoder<msg::Marker> decoder(WireFormat::kCdr, ros2(text));
  EXPECT_FALSE(decoder.as_compiled());
  const auto wanted = test::counted_message<msg::Marker>();
  const std::string bytes =
      cdr(wanted.header, wanted.ns, wanted.id, wanted.type, wanted.action, wanted.pose,
          wanted.scale, wanted.color, wanted.lifetime, wanted.frame_locked, wanted.points,
          wanted.colors, wanted.text, wanted.mesh_resource, wanted.mesh_use_embedded_materials);
  msg::Marker read;
  decoder.decode(bytes, read);
  EXPECT_EQ(flat(read), flat(wanted));
}

TEST(MessageDefinitions, AllTypesAreReadByAnotherDefinition) {
  test::for_each_message([]<typename M>() {
    const M message = test::random_message<M>(11);
    const auto later = [](const MessageDefinition& definition) {
      // A constant before the first field is the end of its line.
      return MessageDefinition{definition.language, "uint8 new_one\n" + definition.text};
    };
    const MessageDecoder<M> one(WireFormat::kRos1, later(ros1(MessageType<M>::ros1_definition())));
    EXPECT_FALSE(one.as_compiled());
    M read;
    one.decode('x' + encoded(WireFormat::kRos1, message), read);
    EXPECT_EQ(flat(read), flat(message)) << MessageType<M>::name();
    const MessageDecoder<M> two(WireFormat::kCdr, later(ros2(MessageType<M>::ros2_definition())));
    two.decode(cdr(std::uint8_t{7}, message), read);
    EXPECT_EQ(flat(read), flat(message)) << MessageType<M>::name();
  });
}

TEST(MessageDefinitions, WideStringsBecomeUtf8) {
  const std::vector<std::uint16_t> units{'a', 0xe4, 0x20ac, 0xd83d, 0xde00};
  EXPECT_EQ(decoded<msg::String>(WireFormat::kCdr, cdr(units), ros2("wstring<=9 data\n")).data,
            "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80");
}

template <typename M = msg::LaserScan>
std::string refusal_of(const MessageDefinition& definition, WireFormat format = WireFormat::kRos1) {
  try {
    (void)MessageDecoder<M>(format, definition);
  } catch (const MessageError& error) {
    return error.what();
  }
  return "";
}

TEST(MessageDefinitionsRefused, WhatCanNotBeUnderstood) {
  const auto says = [](const std::string& text, const char* words) {
    const std::string refusal = refusal_of(ros1(text));
    EXPECT_NE(refusal.find(words), refusal.npos) << text << ": " << refusal;
  };
  says("", "no field of sensor_msgs/LaserScan");
  says("string other\n", "no field of sensor_msgs/LaserScan");
  says("float32 ranges\n", "ranges is not what it is in sensor_msgs/LaserScan");
  says("string[] ranges\n", "ranges is not what it is");
  says("time header\n", "header is not what it is");
  says("float32\n", "has no name of a field");
  says("float32[-1] ranges\n", "no whole number");
  says("float32[99999999999] ranges\n", "no whole number");
  says("float32] ranges\n", "']'");
  says("fl?at ranges\n", "has no type");
  says("Nowhere ranges\n", "lacks the type Nowhere");
  says("float32 range_min\nfloat32 range_min\n", "two fields range_min");
  says("Header header\n", "lacks the type std_msgs/Header");
  says(std::string(2000, 'a') + " x\n", "is too long");
  says(std::string(std::size_t{2} << 20, '#'), "1 MiB");
}

TEST(MessageDefinitionsRefused, TypesWithoutEnd) {
  const std::string own = "A a\n" + kLine + "MSG: p/A\nB[] b\n" + kLine + "MSG: p/B\nA[] a\n";
  EXPECT_NE(refusal_of(ros1(own)).find("contains itself"), std::string::npos);
  std::string deep = "T0 ranges\n";
  for (int i = 0; i < 10'000; ++i) {
    deep += kLine + "MSG: p/T" + std::to_string(i) + "\nT" + std::to_string(i + 1) + " t\n";
  }
  EXPECT_NE(refusal_of(ros1(deep)).find("deeper than 32"), std::string::npos);
  // The deep end is linked before what uses it.
  std::string from_below = "p/E0 first\np/D0 second\n";
  for (int i = 0; i < 25; ++i) {
    const std::string next = std::to_string(i + 1);
    from_below += kLine + "MSG: p/E" + std::to_string(i) + "\n" + (i < 24 ? "E" + next : "int8") +
                  " t\n" + kLine + "MSG: p/D" + std::to_string(i) + "\n" +
                  (i < 24 ? "D" + next : "E0") + " t\n";
  }
  EXPECT_NE(refusal_of(ros1(from_below)).find("deeper than 32"), std::string::npos);
}

TEST(MessageDefinitionsRefused, ManyElementsOfNothing) {
  using namespace std::string_view_literals;
  // 100 to the power of 20 fields without a byte, and four thousand million elements of none.
  std::string text = "float32[] ranges\nT0[] all\nT0[4000000000] fixed\nfloat32 range_min\n";
  for (int i = 0; i < 20; ++i) {
    text += kLine + "MSG: p/T" + std::to_string(i) + "\n";
    for (int k = 0; i < 19 && k < 100; ++k) {
      text += "T" + std::to_string(i + 1) + " t" + std::to_string(k) + "\n";
    }
  }
  const auto scan = decoded<msg::LaserScan>(
      WireFormat::kRos1, packed(std::vector<float>{}, std::uint32_t{4'000'000'000}, 2.0F),
      ros1(text));
  EXPECT_EQ(scan.range_min, 2.0F);
  // In ROS 2 they have a byte each, which the message lacks.
  EXPECT_THROW((void)decoded<msg::LaserScan>(
                   WireFormat::kCdr, cdr(std::vector<float>{}, std::uint32_t{4'000'000'000}, 2.0F),
                   ros2(text)),
               MessageError);
}

TEST(MessageDefinitionsRefused, ArraysLongerThanTheMessage) {
  for (const char* text :
       {"float32[1000000000] ranges\n", "uint8[4294967295] other\nfloat32 range_min",
        "string[1000000000] other\nfloat32 range_min",
        "T[1000000000] other\nfloat32 range_min\nMSG: p/T\nuint8 x\n"}) {
    const MessageDecoder<msg::LaserScan> decoder(WireFormat::kRos1, ros1(text));
    msg::LaserScan scan;
    EXPECT_THROW(decoder.decode(std::string(1000, '\0'), scan), MessageError) << text;
  }
}

TEST(MessageDefinitionsRefused, SmallElementsThatBecomeLargeOnes) {
  const auto definition = ros1("M[] markers\nMSG: p/M\nuint8 id\n");
  const auto read = [&](std::size_t count) {
    return decoded<msg::MarkerArray>(WireFormat::kRos1, packed(std::vector<std::uint8_t>(count, 5)),
                                     definition)
        .markers.size();
  };
  EXPECT_EQ(read(0), 0U);
  EXPECT_THROW((void)read(1'000'000), MessageError);
}

TEST(MessageDefinitionsRefused, AsFastWithManyNames) {
  std::string text;
  for (int i = 0; i < 40'000; ++i)
    text += "T" + std::to_string(i) + " f" + std::to_string(i) + "\n";
  for (int i = 0; i < 20'000; ++i) text += "MSG: p/T" + std::to_string(i) + "\nint8 x\n";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_NE(refusal_of(ros1(text)).find("lacks the type T20000"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

const std::string kOdometryLikeIdl =
    kLine +
    "IDL: nav_msgs/msg/Like\n"
    "// generated from rosidl_adapter/resource/msg.idl.em\n"
    "#include \"geometry_msgs/msg/Pose.idl\"\n\n"
    "module nav_msgs {\n  module msg {\n"
    "    typedef double double__36[36];\n"
    "    module Like_Constants {\n      const octet OK = 0;\n      @verbatim "
    "(language=\"comment\", "
    "text=\"a ) \\\" b\")\n      const string S = \"x;\";\n    };\n"
    "    @verbatim (language=\"comment\", text=\n      \"(one\" \"two\")\n"
    "    struct Like {\n      std_msgs::msg::Header header;\n      @unit (value=\"m\")\n"
    "      string<10> child_frame_id;\n      geometry_msgs::msg::PoseWith pose; /* a; b */\n"
    "      sequence<unsigned long long, 5> more;\n      boolean flag;\n"
    "      @default (value=TRUE)\n      long long numbers[2];\n    };\n  };\n};\n" +
    kLine +
    "IDL: std_msgs/msg/Header\nmodule std_msgs { module msg { struct Header {\n"
    "builtin_interfaces::msg::Time stamp; string frame_id; }; }; };\n" +
    kLine +
    "IDL: geometry_msgs/msg/PoseWith\nmodule geometry_msgs { module msg {\n"
    "typedef double double__36[36]; struct Point { double x; double y; double z; };\n"
    "struct Pose { geometry_msgs::msg::Point position; };\n"
    "struct PoseWith { Pose pose; double__36 covariance; }; }; };\n";

TEST(MessageDefinitionsInIdl, AreReadByTheirNames) {
  const MessageDecoder<msg::Odometry> decoder(WireFormat::kCdr,
                                              {DefinitionLanguage::kRos2Idl, kOdometryLikeIdl});
  EXPECT_FALSE(decoder.as_compiled());
  const auto wanted = test::counted_message<msg::Odometry>();
  msg::Odometry read;
  decoder.decode(
      cdr(wanted.header, wanted.child_frame_id, wanted.pose.pose.position, wanted.pose.covariance,
          std::vector<std::uint64_t>{1, 2}, true, std::array<std::int64_t, 2>{3, 4}),
      read);
  EXPECT_EQ(flat(read.header), flat(wanted.header));
  EXPECT_EQ(read.child_frame_id, wanted.child_frame_id);
  EXPECT_EQ(flat(read.pose.pose.position), flat(wanted.pose.pose.position));
  EXPECT_EQ(read.pose.covariance, wanted.pose.covariance);
}

TEST(MessageDefinitionsInIdl, ThatSayTheSameAreReadAsCompiled) {
  EXPECT_TRUE(MessageDecoder<msg::Vector3>(WireFormat::kCdr,
                                           {DefinitionLanguage::kRos2Idl,
                                            "module a { module msg { struct V { double x; "
                                            "double y; double z; }; }; };"})
                  .as_compiled());
}

TEST(MessageDefinitionsInIdl, CountAsNoneWhenTheyAreNotUnderstood) {
  for (const char* text :
       {"", "struct", "struct S { union u; };", "module a { struct S { double x[", "@a(",
        "enum E { A };", "struct S { sequence<sequence<float>> x; };",
        "struct S { float x[2][3]; };", "struct S { S s; };", "\"", "/*"}) {
    const MessageDefinition definition{DefinitionLanguage::kRos2Idl, text};
    EXPECT_TRUE(MessageDecoder<msg::Vector3>(WireFormat::kCdr, definition).as_compiled()) << text;
    EXPECT_THROW(AnyMessageDecoder(WireFormat::kCdr, definition), MessageError) << text;
  }
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "module a { ";
  EXPECT_THROW(AnyMessageDecoder(WireFormat::kCdr, {DefinitionLanguage::kRos2Idl, deep}),
               MessageError);
}

}  // namespace
}  // namespace loopstone
