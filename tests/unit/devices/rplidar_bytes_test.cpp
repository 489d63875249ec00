#include "devices/rplidar_bytes.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

std::string bytes(std::initializer_list<int> numbers) {
  std::string text;
  for (const int number : numbers) text += static_cast<char>(number);
  return text;
}

TEST(RplidarBytes, RequestsAreThoseOfTheDocument) {
  EXPECT_EQ(rplidar_request(RplidarCommand::kStop), bytes({0xA5, 0x25}));
  EXPECT_EQ(rplidar_request(RplidarCommand::kScan), bytes({0xA5, 0x20}));
  EXPECT_EQ(rplidar_request(RplidarCommand::kExpressScan, little_endian(0, 5)),
            bytes({0xA5, 0x82, 0x05, 0, 0, 0, 0, 0, 0x22}));
  EXPECT_EQ(rplidar_request(RplidarCommand::kMotorPwm, little_endian(660, 2)),
            bytes({0xA5, 0xF0, 0x02, 0x94, 0x02, 0xC1}));
}

TEST(RplidarBytes, NumbersAreLittleEndian) {
  EXPECT_EQ(little_endian(0x1234, 4), bytes({0x34, 0x12, 0, 0}));
  EXPECT_EQ(little_endian(bytes({0x34, 0x12, 0xFF})), 0xFF1234U);
}

TEST(RplidarBytes, DescriptorsAreFoundBehindAnything) {
  const std::string noise = bytes({0xA5, 0x5A, 0x00, 0xA5, 0xA5});
  const auto found = find_descriptor(noise + bytes({0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x81, 0x3E}),
                                     RplidarAnswer::kNodes);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->length, 5U);
  EXPECT_TRUE(found->is_stream);
  EXPECT_EQ(found->end, noise.size() + 7);
  EXPECT_FALSE(find_descriptor(bytes({0xA5, 0x5A, 0x05, 0, 0, 0x40}), RplidarAnswer::kNodes));
  EXPECT_FALSE(find_descriptor(bytes({0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x82}), RplidarAnswer::kNodes));
}

TEST(RplidarBytes, AnswersAreWhole) {
  const std::string head = bytes({0xA5, 0x5A, 0x03, 0, 0, 0, 0x06});
  EXPECT_EQ(find_answer("noise" + head + bytes({0, 1, 2, 9}), RplidarAnswer::kHealth, 3),
            bytes({0, 1, 2}));
  EXPECT_FALSE(find_answer(head + bytes({0, 1}), RplidarAnswer::kHealth, 3));
  EXPECT_FALSE(find_answer(head + bytes({0, 1, 2}), RplidarAnswer::kHealth, 4));
  // One that is too short is passed over.
  EXPECT_EQ(find_answer(bytes({0xA5, 0x5A, 0x01, 0, 0, 0, 0x06, 7}) + head + bytes({0, 1, 2}),
                        RplidarAnswer::kHealth, 3),
            bytes({0, 1, 2}));
}

TEST(RplidarBytes, InfoTellsNamesAsTheyAreSold) {
  const RplidarInfo info = rplidar_info(bytes({0x18, 29, 1, 7}) + std::string(16, '\xAB'));
  EXPECT_EQ(info.name(), "A1M8");
  EXPECT_EQ(info.serial, "ABABABABABABABABABABABABABABABAB");
  EXPECT_TRUE(info.has_firmware(1, 24));
  EXPECT_TRUE(info.has_firmware(1, 29));
  EXPECT_FALSE(info.has_firmware(1, 30));
  EXPECT_FALSE(info.has_firmware(2, 0));
  EXPECT_EQ(RplidarInfo{.model = 0x2C}.name(), "A2M12");
  EXPECT_EQ(RplidarInfo{.model = 0x31}.name(), "A3M1");
  EXPECT_EQ(RplidarInfo{.model = 0x41}.name(), "C1M1");
  EXPECT_EQ(RplidarInfo{.model = 0x61}.name(), "S1M1");
  EXPECT_EQ(RplidarInfo{.model = 0xC1}.name(), "model 193");
}

}  // namespace
}  // namespace loopstone
