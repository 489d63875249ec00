#include <gtest/gtest.h>

#include "filled_message.hpp"

namespace loopstone {
namespace {

using test::encoded;

AnyMessageDecoder::Values values_of(const msg::Marker& marker, WireFormat format,
                                    std::size_t most = 64) {
  using Type = MessageType<msg::Marker>;
  const bool one = format == WireFormat::kRos1;
  const AnyMessageDecoder decoder(
      format, {one ? DefinitionLanguage::kRos1Msg : DefinitionLanguage::kRos2Msg,
               one ? Type::ros1_definition() : Type::ros2_definition()});
  return decoder.decode(encoded(format, marker), most);
}

TEST(AnyMessages, AreTellingPathsAndValues) {
  auto marker = test::counted_message<msg::Marker>();
  marker.lifetime = Duration::from_seconds(-2.5);
  for (const WireFormat format : {WireFormat::kRos1, WireFormat::kCdr}) {
    const auto values = values_of(marker, format);
    EXPECT_EQ(values.stamps.at("header.stamp"), marker.header.stamp);
    EXPECT_EQ(values.strings.at("header.frame_id"), marker.header.frame_id);
    EXPECT_EQ(values.strings.at("text"), marker.text);
    EXPECT_EQ(values.numbers.at("pose.position.y"), marker.pose.position.y);
    EXPECT_EQ(values.numbers.at("points[2].z"), marker.points[2].z);
    EXPECT_EQ(values.numbers.at("frame_locked"), marker.frame_locked ? 1.0 : 0.0);
    EXPECT_EQ(values.numbers.at("lifetime"), -2.5);
    EXPECT_EQ(values.numbers.contains("header.seq"), format == WireFormat::kRos1);
    EXPECT_EQ(values.strings.contains("mesh_file.filename"), format == WireFormat::kCdr);
  }
}

TEST(AnyMessages, OfLongArraysTheFirstElementsAreTold) {
  const auto marker = test::counted_message<msg::Marker>();
  const auto values = values_of(marker, WireFormat::kCdr, 2);
  EXPECT_TRUE(values.numbers.contains("points[1].x"));
  EXPECT_FALSE(values.numbers.contains("points[2].x"));
  EXPECT_EQ(values.strings.at("mesh_resource"), marker.mesh_resource) << "what follows is read";
}

TEST(AnyMessages, ArraysOfTheMessagesOwnPackage) {
  const AnyMessageDecoder decoder(WireFormat::kRos1,
                                  {DefinitionLanguage::kRos1Msg,
                                   "Wheel left\nWheel[2] others\nduration age\nbyte b\nchar c\n"
                                   "MSG: robot/Wheel\nint64[3] counts\n"});
  std::string bytes;
  WireWriter out(WireFormat::kRos1, bytes);
  for (const std::int64_t count : {1, 2, 3, 4, 5, 6, 7, 8, -9}) out.number(count);
  out.nanoseconds(1'500'000'000, true);
  out.number(std::uint8_t{200});
  out.number(std::uint8_t{201});
  const auto values = decoder.decode(bytes);
  EXPECT_EQ(values.numbers.at("left.counts[2]"), 3.0);
  EXPECT_EQ(values.numbers.at("others[1].counts[2]"), -9.0);
  EXPECT_EQ(values.numbers.at("age"), 1.5);
  EXPECT_EQ(values.numbers.at("b"), 200.0);
  EXPECT_EQ(values.numbers.at("c"), 201.0);
  bytes.pop_back();
  EXPECT_THROW((void)decoder.decode(bytes), MessageError);
}

TEST(AnyMessages, WithoutFieldsHaveAByteInCdr) {
  using namespace std::string_view_literals;
  const AnyMessageDecoder cdr(WireFormat::kCdr, {DefinitionLanguage::kRos2Msg, "# nothing\n"});
  const auto values = cdr.decode("\0\1\0\0\0"sv);
  EXPECT_TRUE(values.numbers.empty());
  const AnyMessageDecoder ros1(WireFormat::kRos1, {DefinitionLanguage::kRos1Msg, ""});
  EXPECT_TRUE(ros1.decode({}).numbers.empty());
}

TEST(AnyMessages, AreBounded) {
  std::string text;
  for (int i = 0; i < 30'000; ++i) text += "uint8 a" + std::to_string(i) + "\n";
  text += "string last\n";
  const AnyMessageDecoder decoder(WireFormat::kRos1, {DefinitionLanguage::kRos1Msg, text});
  const auto values = decoder.decode(std::string(30'004, '\0'));
  EXPECT_EQ(values.numbers.size(), 20'000U);
  EXPECT_TRUE(values.strings.empty());
}

TEST(AnyMessages, NeedADefinition) {
  EXPECT_THROW(AnyMessageDecoder(WireFormat::kCdr, {}), MessageError);
  EXPECT_THROW(AnyMessageDecoder(WireFormat::kCdr, {DefinitionLanguage::kRos2Msg, "Missing x\n"}),
               MessageError);
}

}  // namespace
}  // namespace loopstone
