#include "loopstone/formats/session_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/sensor/log_digest.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"
#include "source_folder.hpp"
#include "support/passage_drive.hpp"
#include "support/pose_near.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

/// With something in every field that is not the mapper's.
Session sample() {
  Session session;
  session.terms = {.version = "0.1.0",
                   .options_toml = "a = 1\n",
                   .robot_toml = "b = 2\n",
                   .mounts_from_log = false,
                   .start_s = 1.5,
                   .duration_s = 20.0,
                   .max_scans = 7};
  session.log.add(OdometryPose{Stamp{5}, {1.0, 2.0, 3.0}});
  session.wall_s = 3.0;
  session.cpu_s = 4.0;
  return session;
}

/// A drive through a passage, as far as half its scans.
Session of_a_drive() {
  Session session = sample();
  Mapper mapper({}, test::short_submaps(), Threads{1});
  test::drive_through_a_passage(mapper, 0, 12);
  session.mapper = mapper.save_state().get();
  // Times differ from run to run.
  session.mapper.so_far.statistics.front_end_s = 0.0;
  session.mapper.back_end.loop_closing_s = 0.0;
  session.mapper.back_end.optimisation_s = 0.0;
  return session;
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
  const std::string bytes = format_session(of_a_drive());
  EXPECT_EQ(format_session(parse_session(bytes, "file")), bytes);
  const Session session = parse_session(format_session(sample()), "file");
  EXPECT_EQ(difference(session.terms, sample().terms), "");
  EXPECT_EQ(session.log, sample().log);
  EXPECT_EQ(session.wall_s, 3.0);
  EXPECT_EQ(session.cpu_s, 4.0);
  const test::TempDir folder;
  EXPECT_EQ(write_session(folder / "s", of_a_drive()), static_cast<std::int64_t>(bytes.size()));
  EXPECT_EQ(folder.read("s"), bytes);
  EXPECT_EQ(format_session(read_session(folder / "s")), bytes);
  EXPECT_EQ(folder.names(), std::vector<std::string>{"s"}) << "nothing temporary stays";
}

TEST(SessionFile, BeginsAsDescribed) {
  const std::string bytes = format_session(sample());
  EXPECT_EQ(bytes.substr(0, 12), std::string("LOOPSESS\x09\0\0\0", 12))
      << "as docs/session.md has it";
  std::uint64_t length = 0;
  ByteReader(std::string_view(bytes).substr(16))(length);
  EXPECT_EQ(bytes.size(), 8U + 4U + 4U + 8U + length + 4U) << "head, length, content, checksum";
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
  EXPECT_THAT(refusal(bytes + '\0'), HasSubstr("follow the end"));
}

TEST(SessionFile, ErrorsNameTheFileAndTheOffset) {
  std::string bytes = format_session(sample());
  bytes[16 + 20] ^= 1;  // in the content
  EXPECT_THAT(refusal(bytes), HasSubstr("file (byte 16)"));
  EXPECT_THAT(refusal(bytes), HasSubstr("checksum"));
  EXPECT_THAT(refusal("no session at all"), HasSubstr("no session of loopstone"));
  EXPECT_THAT(refusal(""), HasSubstr("cut off"));
}

/// Of each version there is a file as its program wrote it. The present one is gone on with; one of
/// any other is named. Whoever changes a field of a session changes the bytes of the present
/// version, and this test fails: then raise Session::kVersion and store a file of the new one.
TEST(SessionFile, StoredFilesOfEveryVersionAreReadOrNamed) {
  const std::string folder = std::string(LOOPSTONE_SOURCE_DIR) + "/tests/unit/formats/sessions";
  for (std::uint32_t version = 1; version < Session::kVersion; ++version) {
    const std::string number = std::to_string(version);
    try {
      (void)read_session(fmt::format("{}/version_{}.loopstone", folder, number));
      ADD_FAILURE() << "version " << number << " was taken";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr("of version " + number + " of the format"));
      EXPECT_THAT(error.what(), HasSubstr("version " + std::to_string(Session::kVersion)));
    }
  }
  const std::string name = "version_" + std::to_string(Session::kVersion) + ".loopstone";
  Session stored;
  try {
    stored = read_session((folder + "/") + name);
  } catch (const DataError& error) {
    write_session(testing::TempDir() + name, of_a_drive());
    FAIL() << error.what() << "; one of the present program is in " << testing::TempDir() << name;
  }
  // It goes on, and ends as a drive without a break does.
  Mapper resumed({}, test::short_submaps(), Threads{1});
  resumed.restore_state(std::move(stored.mapper));
  test::drive_through_a_passage(resumed, 12, 24);
  Mapper whole({}, test::short_submaps(), Threads{1});
  test::drive_through_a_passage(whole, 0, 24);
  const MapResult after = resumed.finish();
  const MapResult expected = whole.finish();
  ASSERT_EQ(after.trajectory.size(), 24U);
  ASSERT_EQ(after.trajectory.size(), expected.trajectory.size());
  for (std::size_t i = 0; i < expected.trajectory.size(); ++i) {
    EXPECT_EQ(after.trajectory.poses()[i].stamp, expected.trajectory.poses()[i].stamp);
    // The file may be of another compiler.
    EXPECT_TRUE(test::pose_near(after.trajectory.poses()[i].pose,
                                expected.trajectory.poses()[i].pose, 1e-6, 1e-6));
  }
  EXPECT_EQ(after.graph.poses.size(), expected.graph.poses.size());
}

TEST(SessionFile, AFileThatCannotBeWrittenKeepsTheOldOne) {
  const test::TempDir folder;
  write_session(folder / "s", sample());
  EXPECT_THROW(write_session(folder / "no/such/folder/s", sample()), DataError);
  EXPECT_THROW(write_session("/dev/full", sample()), DataError);
  EXPECT_THROW((void)read_session(folder / "nothing"), DataError);
  EXPECT_EQ(folder.read("s"), format_session(sample()));
}

/// What read_kept_state says of a folder; empty: nothing.
std::string kept_refusal(const std::string& folder, const std::string& to_do) {
  try {
    (void)read_kept_state(folder, to_do);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(KeptState, LiesInTheFolderOfTheResults) {
  const test::TempDir folder;
  const std::string path = folder.path().string();
  EXPECT_THAT(kept_refusal(path, "edit"), HasSubstr("holds no state.loopstone to edit; "));
  Session session = sample();
  session.terms.version = kVersion;
  write_session(kept_state_path(path), session);
  EXPECT_EQ(format_session(read_kept_state(path, "edit")), format_session(session));
  EXPECT_FALSE(is_edited_map(path));
  folder.write("edits.toml", "");
  EXPECT_TRUE(is_edited_map(path));
  EXPECT_EQ(kept_refusal(path, "edit"), "") << "its state is there all the same";
  remove_kept_state(path);
  EXPECT_THAT(kept_refusal(path, "go on from"), HasSubstr("to go on from; "));
  remove_kept_state(path);  // nothing is there
}

TEST(KeptState, OfAnotherVersionIsRefused) {
  const test::TempDir folder;
  Session session = sample();
  session.terms.version = "0.0.0";
  write_session(folder / "state.loopstone", session);
  EXPECT_THAT(kept_refusal(folder.path().string(), "edit"),
              HasSubstr("is of another kind of run: loopstone: 0.0.0 then"));
}

}  // namespace
}  // namespace loopstone
