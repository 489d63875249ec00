#include "loopstone/formats/site_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "source_folder.hpp"
#include "support/passage_drive.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using testing::HasSubstr;

constexpr const char* kOptions = "calibration = false\n";

DriveRecord passage_record() {
  Mapper mapper({}, test::short_submaps(), Threads{1});
  test::drive_through_a_passage(mapper, 0, 20);
  (void)mapper.judge_robot();
  return record_of(mapper.save_state().get(), test::short_submaps());
}

SiteSession session_of(const std::string& name, std::int64_t begins_s) {
  return {.log = "/logs/" + name,
          .digest = "20 messages, checksum " + name,
          .begins = Stamp::from_seconds(static_cast<double>(begins_s)),
          .added = "2026-11-26T12:00:00Z",
          .robot = "# a robot\n",
          .status = SessionStatus::kPending,
          .reason = "nothing of it was recognised",
          .scans = 20,
          .path_m = 1.9,
          .duration_s = 1.9,
          .verdict = "good",
          .sentence = "Good."};
}

template <typename Value>
std::string bytes_of(const Value& value) {
  ByteWriter writer;
  writer(value);
  return writer.take();
}

/// A site of two sessions, the later one first.
std::string made_site(const TempDir& folder, const DriveRecord& record) {
  const std::string path = folder / "a.site";
  SiteFile::create(path, kOptions);
  SiteFile file(path, SiteAccess::kWrite);
  file.begin_change();
  (void)file.add(session_of("tuesday", 2000), &record);
  (void)file.add(session_of("monday", 1000), &record);
  file.add_event({"2026-11-26T12:00:00Z", "add", "/logs/monday", "pending"});
  file.commit();
  return path;
}

std::string refusal(const auto& work) {
  try {
    work();
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(SiteFile, KeepsWhatItWasGiven) {
  const TempDir folder;
  const DriveRecord record = passage_record();
  const SiteFile file(made_site(folder, record), SiteAccess::kRead);
  EXPECT_EQ(file.options_toml(), kOptions);
  const std::vector<SiteSession> sessions = file.sessions();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions[0].log, "/logs/monday");
  EXPECT_EQ(sessions[1].log, "/logs/tuesday");
  const SiteSession wanted = session_of("monday", 1000);
  EXPECT_EQ(sessions[0].digest, wanted.digest);
  EXPECT_EQ(sessions[0].begins, wanted.begins);
  EXPECT_EQ(sessions[0].added, wanted.added);
  EXPECT_EQ(sessions[0].robot, wanted.robot);
  EXPECT_EQ(sessions[0].status, wanted.status);
  EXPECT_EQ(sessions[0].reason, wanted.reason);
  EXPECT_EQ(sessions[0].scans, wanted.scans);
  EXPECT_EQ(sessions[0].path_m, wanted.path_m);
  EXPECT_EQ(sessions[0].sentence, wanted.sentence);
  EXPECT_EQ(bytes_of(*file.record(sessions[0])), bytes_of(record));
  ASSERT_EQ(file.events().size(), 1U);
  EXPECT_EQ(file.events().front().text, "pending");
  EXPECT_TRUE(file.check().empty());
}

TEST(SiteFile, KeepsWhatTiesSessionsAndForgetsItWithThem) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  SiteFile file(path, SiteAccess::kWrite);
  const std::vector<SiteSession> sessions = file.sessions();
  SitePair pair{.older = sessions[0].id, .newer = sessions[1].id};
  pair.pair.closures.resize(2);
  pair.pair.closures[0].state = ClosureState::kStanding;
  pair.pair.tried[{{3}, {1}}] = {1.0, 2.0, 0.5};
  pair.pair.seen[{{3}, {1}}] = {true, false, true};
  const SitePlacement placement{sessions[1].id, {{{1.0, 2.0, 3.0}}, {true}, true}};
  file.begin_change();
  file.set_joins({pair}, {placement});
  file.commit();
  ASSERT_EQ(file.pairs().size(), 1U);
  EXPECT_EQ(bytes_of(file.pairs().front().pair), bytes_of(pair.pair));
  ASSERT_EQ(file.placements().size(), 1U);
  EXPECT_EQ(bytes_of(file.placements().front().placement), bytes_of(placement.placement));
  file.begin_change();
  file.remove(sessions[1].id);
  file.commit();
  EXPECT_TRUE(file.pairs().empty());
  EXPECT_TRUE(file.placements().empty());
  EXPECT_EQ(file.sessions().size(), 1U);
  EXPECT_TRUE(file.check().empty());
}

TEST(SiteFile, WhatWasNotCommittedNeverHappened) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  {
    SiteFile file(path, SiteAccess::kWrite);
    file.begin_change();
    (void)file.add(session_of("wednesday", 3000), nullptr);
    EXPECT_EQ(file.sessions().size(), 3U);
  }
  EXPECT_EQ(SiteFile(path, SiteAccess::kRead).sessions().size(), 2U);
}

TEST(SiteFile, TwoWritersExcludeEachOtherAndReadersNeverWait) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  SiteFile writer(path, SiteAccess::kWrite);
  SiteFile other(path, SiteAccess::kWrite);
  const SiteFile reader(path, SiteAccess::kRead);
  writer.begin_change();
  writer.remove(writer.sessions().front().id);
  EXPECT_EQ(reader.sessions().size(), 2U) << "as it was before";
  int asked = 0;
  EXPECT_THROW(other.begin_change([&] { return ++asked < 2; }), UsageError);
  EXPECT_EQ(asked, 2);
  writer.commit();
  EXPECT_EQ(reader.sessions().size(), 1U);
  other.begin_change([] { return false; });
  other.commit();
}

TEST(SiteFile, WhatIsNoSiteIsSaid) {
  const TempDir folder;
  const auto open = [&](const std::string& name) {
    return refusal([&] { const SiteFile file(folder / name, SiteAccess::kRead); });
  };
  EXPECT_THAT(open("none"), HasSubstr("there is no such site"));
  folder.write("text",
               "a robot's log, and a long one, so that it is longer than a head of SQLite "
               "and yet no database of any kind whatever\n");
  EXPECT_THAT(open("text"), HasSubstr("no site of loopstone"));
  EXPECT_FALSE(is_site(folder / "text"));
  EXPECT_FALSE(is_site(folder / "none"));
  EXPECT_FALSE(is_site(folder.path().string()));
  const std::string path = made_site(folder, passage_record());
  EXPECT_TRUE(is_site(path));
  EXPECT_THAT(refusal([&] { SiteFile::create(path, kOptions); }), HasSubstr("is there already"));
}

/// Where the version of the schema and the application stand in a database (SQLite, "Database File
/// Format", 1.3).
constexpr std::size_t kVersionAt = 63;

TEST(SiteFile, ASiteOfANewerProgramIsLeftAlone) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  std::string bytes = folder.read("a.site");
  bytes[kVersionAt] = 99;
  folder.write("newer.site", bytes);
  EXPECT_THAT(refusal([&] { const SiteFile file(folder / "newer.site", SiteAccess::kWrite); }),
              HasSubstr("written by a newer loopstone"));
  EXPECT_EQ(folder.read("newer.site"), bytes);
}

TEST(SiteFile, ADamagedSessionIsNamedAndTheOthersStay) {
  const TempDir folder;
  const DriveRecord record = passage_record();
  made_site(folder, record);
  std::string bytes = folder.read("a.site");
  // In the last page of a record: a page that is full of packed bytes.
  constexpr std::string_view kZstd{"\x28\xb5\x2f\xfd", 4};
  const std::size_t at = bytes.find(kZstd);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 200] = static_cast<char>(bytes[at + 200] ^ 0x5a);
  folder.write("damaged.site", bytes);
  const SiteFile file(folder / "damaged.site", SiteAccess::kRead);
  const std::vector<std::string> problems = file.check();
  ASSERT_FALSE(problems.empty());
  EXPECT_THAT(problems.front(), HasSubstr("session"));
  EXPECT_THAT(problems.front(), HasSubstr("is damaged"));
  EXPECT_THAT(problems.front(), HasSubstr("loopstone site prune --session"));
  int whole = 0;
  for (const SiteSession& session : file.sessions()) {
    if (refusal([&] { (void)file.record(session); }).empty()) ++whole;
  }
  EXPECT_EQ(whole, 1);
}

TEST(SiteFile, AnyDamageIsToldOrHarmless) {
  const TempDir folder;
  const DriveRecord record = passage_record();
  made_site(folder, record);
  const std::string good = folder.read("a.site");
  for (std::size_t at = 0; at < good.size(); at += 97) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0xff);
    folder.write("damaged.site", bytes);
    const std::string told = refusal([&] {
      const SiteFile file(folder / "damaged.site", SiteAccess::kRead);
      for (const SiteSession& session : file.sessions()) {
        if (session.status != SessionStatus::kPending) continue;
        EXPECT_EQ(bytes_of(*file.record(session)), bytes_of(record)) << at;
      }
      (void)file.check();
    });
    EXPECT_TRUE(told.empty() || told.find("damaged.site") != std::string::npos) << at << told;
  }
}

/// Of each version of the schema there is a site as its program wrote it. Whoever changes the form
/// of a record changes the bytes that are read here, and this test fails: then raise
/// DriveRecord::kVersion, and say what becomes of older ones.
TEST(SiteFile, StoredSitesOfEveryVersionAreRead) {
  const std::string stored =
      std::string(LOOPSTONE_SOURCE_DIR) + "/tests/unit/formats/sites/schema_1.site";
  const TempDir folder;
  if (!std::filesystem::exists(stored)) {
    made_site(folder, passage_record());
    std::filesystem::copy_file(folder / "a.site", testing::TempDir() + "schema_1.site",
                               std::filesystem::copy_options::overwrite_existing);
    FAIL() << "one of the present program is in " << testing::TempDir() << "schema_1.site";
  }
  std::filesystem::copy_file(stored, folder / "old.site");
  const SiteFile file(folder / "old.site", SiteAccess::kWrite);
  EXPECT_TRUE(file.check().empty());
  const std::vector<SiteSession> sessions = file.sessions();
  ASSERT_EQ(sessions.size(), 2U);
  const auto record = file.record(sessions[0]);
  const DriveRecord now = passage_record();
  EXPECT_EQ(record->track.size(), now.track.size());
  EXPECT_EQ(record->back_end.chain.submaps.size(), now.back_end.chain.submaps.size());
}

TEST(SiteFile, RoomThatIsFreeIsGivenBack) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  SiteFile file(path, SiteAccess::kWrite);
  const std::int64_t before = file.bytes();
  file.begin_change();
  for (const SiteSession& session : file.sessions()) file.drop_record(session.id);
  file.commit();
  file.compact();
  EXPECT_LT(file.bytes(), before);
  EXPECT_TRUE(file.check().size() == 2U) << "sessions that say that they are kept, and are not";
}

}  // namespace
}  // namespace loopstone
