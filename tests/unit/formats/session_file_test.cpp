#include "loopstone/formats/session_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "formats/crc32.hpp"
#include "loopstone/base/byte_archive.hpp"
#include "loopstone/formats/log_digest.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

std::vector<StateChunk> sample() {
  return {{.tag = "ABCD", .version = 3, .bytes = std::string("some\0bytes", 10)},
          {.tag = "NONE", .version = 1, .bytes = {}},
          {.tag = "MORE", .version = 65535, .optional = true, .bytes = std::string(300, '\xff')}};
}

void expect_equal(const std::vector<StateChunk>& a, const std::vector<StateChunk>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].tag, b[i].tag);
    EXPECT_EQ(a[i].version, b[i].version);
    EXPECT_EQ(a[i].optional, b[i].optional);
    EXPECT_EQ(a[i].bytes, b[i].bytes);
  }
}

std::string refusal(const std::string& bytes) {
  try {
    (void)parse_session(bytes, "file");
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(SessionFile, WhatIsWrittenIsReadBack) {
  expect_equal(parse_session(format_session(sample()), "file"), sample());
  expect_equal(parse_session(format_session({}), "file"), {});
  const test::TempDir folder;
  write_session(folder / "s", sample());
  EXPECT_EQ(folder.read("s"), format_session(sample()));
  expect_equal(read_session(folder / "s"), sample());
  EXPECT_EQ(folder.names(), std::vector<std::string>{"s"}) << "nothing temporary stays";
}

TEST(SessionFile, BeginsAsDescribed) {
  const std::string bytes = format_session({});
  EXPECT_EQ(bytes.substr(0, 12), std::string("LOOPSESS\x01\0\0\0", 12));
  EXPECT_EQ(bytes.size(), 8u + 4u + 4u + (4u + 2u + 2u + 8u + 4u + 4u)) << "head and end";
  EXPECT_EQ(bytes.substr(16, 4), "END ");
}

TEST(SessionFile, AnyChangedByteIsNoticed) {
  const std::string bytes = format_session(sample());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int change : {0x01, 0x80, 0xff, 0x20}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ change);
      EXPECT_NE(refusal(damaged), "") << at << " ^ " << change;
    }
  }
}

TEST(SessionFile, AnyCutIsNoticed) {
  const std::string bytes = format_session(sample());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(refusal(bytes.substr(0, size)), "") << size;
  }
}

TEST(SessionFile, APartThatIsLeftOutComesTwiceOrFollowsTheEndIsNoticed) {
  const std::string whole = format_session(sample());
  const std::size_t head = 16;
  const std::size_t first = 16 + 10 + 4;  // of the chunk ABCD
  EXPECT_THAT(refusal(whole.substr(0, head) + whole.substr(head + first)),
              HasSubstr("lacks parts"));
  EXPECT_THAT(refusal(whole.substr(0, head + first) + whole.substr(head)), HasSubstr("twice"));
  EXPECT_THAT(refusal(whole + '\0'), HasSubstr("follow the end"));
}

TEST(SessionFile, AnEndOfAnotherVersionIsNoticed) {
  const std::string bytes = format_session({});
  const std::string head = bytes.substr(0, 16);
  for (const std::size_t at : {std::size_t{4}, std::size_t{6}}) {  // of the version, of the flags
    std::string end = bytes.substr(16, bytes.size() - 16 - 4);
    end[at] = static_cast<char>(end[at] ^ 1);
    ByteWriter checksum;
    checksum(crc32_of(end));
    EXPECT_THAT(refusal(head + end + checksum.take()), HasSubstr("the end")) << at;
  }
}

TEST(SessionFile, AFileWithoutPartsIsRefusedByName) {
  const test::TempDir folder;
  write_session(folder / "s", {});
  try {
    (void)read_session(folder / "s");
    FAIL() << "taken";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr(folder / "s"));
  }
}

TEST(SessionFile, ErrorsNameTheFileAndTheOffset) {
  std::string bytes = format_session(sample());
  bytes[16 + 20] ^= 1;  // in the payload of the first chunk
  EXPECT_THAT(refusal(bytes), HasSubstr("file (byte 16)"));
  EXPECT_THAT(refusal(bytes), HasSubstr("checksum"));
  EXPECT_THAT(refusal("no session at all"), HasSubstr("no session of loopstone"));
  EXPECT_THAT(refusal(""), HasSubstr("cut off"));
}

TEST(SessionFile, AnotherVersionOfTheFormatIsNamed) {
  // Head of a version 2, with its right checksum (zlib.crc32 of the twelve bytes before).
  const std::string head("LOOPSESS\x02\0\0\0", 12);
  ByteWriter checksum;
  checksum(std::uint32_t{0x84d5655e});
  EXPECT_THAT(refusal(head + checksum.take()), HasSubstr("version 2"));
}

TEST(SessionFile, AFileThatCannotBeWrittenKeepsTheOldOne) {
  const test::TempDir folder;
  write_session(folder / "s", sample());
  EXPECT_THROW(write_session(folder / "no/such/folder/s", sample()), DataError);
  EXPECT_THROW(write_session("/dev/full", sample()), DataError);
  EXPECT_THROW((void)read_session(folder / "nothing"), DataError);
  expect_equal(read_session(folder / "s"), sample());
}

TEST(LogDigest, TellsLogsApartByTheirMessages) {
  const auto digest = [](const std::vector<SensorMessage>& messages) {
    LogDigest result;
    for (const SensorMessage& message : messages) result.add(message);
    return result;
  };
  LaserScan scan{.stamp = Stamp{5}, .ranges_m = {1.0F, 2.0F}};
  const OdometryPose pose{Stamp{5}, {1.0, 2.0, 3.0}};
  const std::vector<SensorMessage> log{scan, pose};
  EXPECT_EQ(digest(log), digest(log));
  EXPECT_EQ(digest(log).messages(), 2);
  EXPECT_NE(digest(log), digest({scan}));
  EXPECT_NE(digest(log), digest({pose, scan}));
  scan.ranges_m[1] = 2.0001F;
  EXPECT_NE(digest(log), digest({scan, pose}));
  // A folder may have moved; a picture's stamp is what it is known by.
  const RgbdFrame frame{Stamp{7}, Stamp{8}, "a/1.png", "a/2.png"};
  EXPECT_EQ(digest({frame}), digest({RgbdFrame{Stamp{7}, Stamp{8}, "b/1.png", "b/2.png"}}));
  EXPECT_NE(digest({frame}), digest({RgbdFrame{Stamp{7}, Stamp{9}, "a/1.png", "a/2.png"}}));
}

}  // namespace
}  // namespace loopstone
