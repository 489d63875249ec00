#include "loopstone/formats/site_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/sqlite_database.hpp"
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
  std::string path = folder / "a.site";
  SiteFile::create(path, kOptions);
  SiteFile file(path, SiteAccess::kWrite);
  file.begin_change();
  (void)file.add(session_of("tuesday", 2000), &record);
  (void)file.add(session_of("monday", 1000), &record);
  file.add_event({"2026-11-26T12:00:00Z", "add", "/logs/monday", "pending"});
  file.commit();
  return path;
}

const Polygon2 kTriangle{{{0.5, 0.25}, {1.5, 0.25}, {1.0, 1.0 / 3.0}}};

/// Leaves the first session out, and draws a wall on it.
void add_edits(const std::string& path) {
  SiteFile file(path, SiteAccess::kWrite);
  file.begin_change();
  const std::int64_t session = file.sessions().front().id;
  (void)file.add_edit({.at = "2026-11-27T12:00:00Z", .excluded = session});
  (void)file.add_edit({.at = "2026-11-27T13:00:00Z",
                       .kind = SiteEditKind::kWall,
                       .anchor = SiteAnchor{session, 0},
                       .polygon = kTriangle});
  file.commit();
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
class StoredSite : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] static std::string stored() {
    return fmt::format("{}/tests/unit/formats/sites/schema_{}.site", LOOPSTONE_SOURCE_DIR,
                       GetParam());
  }
};

TEST_P(StoredSite, IsReadAndBroughtUpToDate) {
  const TempDir folder;
  if (!std::filesystem::exists(stored())) {
    const std::string made = made_site(folder, passage_record());
    add_edits(made);
    const std::string kept = testing::TempDir() + "a.site";
    std::filesystem::copy_file(made, kept, std::filesystem::copy_options::overwrite_existing);
    FAIL() << "one of the present program is in " << kept;
  }
  std::filesystem::copy_file(stored(), folder / "old.site");
  const auto expect_whole = [&](const SiteFile& file) {
    EXPECT_TRUE(file.check().empty());
    const std::vector<SiteSession> sessions = file.sessions();
    ASSERT_EQ(sessions.size(), 2U);
    const auto record = file.record(sessions[0]);
    const DriveRecord now = passage_record();
    EXPECT_EQ(record->track.size(), now.track.size());
    EXPECT_EQ(record->back_end.chain.submaps.size(), now.back_end.chain.submaps.size());
    EXPECT_EQ(file.edits().size(), GetParam() == 1 ? 0U : 2U);
  };
  const std::string bytes = folder.read("old.site");
  expect_whole(SiteFile(folder / "old.site", SiteAccess::kRead));
  EXPECT_EQ(folder.read("old.site"), bytes) << "it was only read";
  expect_whole(SiteFile(folder / "old.site", SiteAccess::kWrite));
  SiteFile file(folder / "old.site", SiteAccess::kWrite);
  file.begin_change();
  for (const SiteEdit& edit : file.edits()) file.remove_edit(edit.id);
  const std::int64_t id = file.sessions()[1].id;
  (void)file.add_edit({.at = "2026-11-28T12:00:00Z", .excluded = id});
  file.commit();
  const SiteFile now(folder / "old.site", SiteAccess::kRead);
  EXPECT_EQ(now.sessions()[1].status, SessionStatus::kExcluded);
  EXPECT_TRUE(now.check().empty());
}

INSTANTIATE_TEST_SUITE_P(SchemaVersions, StoredSite, testing::Values(1, 2));

TEST(SiteFile, KeepsEditsAndForgetsThemWithTheirSessions) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  add_edits(path);
  SiteFile file(path, SiteAccess::kWrite);
  const std::vector<SiteEdit> edits = file.edits();
  ASSERT_EQ(edits.size(), 2U);
  EXPECT_EQ(edits[0].kind, SiteEditKind::kExclude);
  EXPECT_EQ(edits[0].at, "2026-11-27T12:00:00Z");
  EXPECT_EQ(edits[1].kind, SiteEditKind::kWall);
  EXPECT_EQ(edits[1].polygon, kTriangle);
  EXPECT_EQ(edits[1].anchor, (SiteAnchor{edits[0].excluded, 0}));
  const std::vector<SiteSession> sessions = file.sessions();
  EXPECT_EQ(sessions[0].status, SessionStatus::kExcluded);
  EXPECT_THAT(sessions[0].reason, HasSubstr("edit 1"));
  EXPECT_EQ(sessions[1].status, SessionStatus::kPending);
  // The polygon stays, on nothing; what was excluded is gone for good.
  file.begin_change();
  file.remove(sessions[0].id);
  file.commit();
  ASSERT_EQ(file.edits().size(), 1U);
  EXPECT_FALSE(file.edits()[0].anchor);
  file.begin_change();
  const SiteAnchor other{sessions[1].id, 3};
  file.set_place(edits[1].id, other, box_polygon({0.0, 0.0}, {2.0, 1.0}));
  EXPECT_EQ(file.edits()[0].anchor, other);
  EXPECT_EQ(file.edits()[0].polygon, box_polygon({0.0, 0.0}, {2.0, 1.0}));
  EXPECT_TRUE(file.remove_edit(edits[1].id));
  EXPECT_FALSE(file.remove_edit(edits[1].id));
  // Its number is never given again.
  EXPECT_EQ(file.add_edit({.at = "now", .kind = SiteEditKind::kFree, .polygon = kTriangle}), 3);
  file.commit();
  EXPECT_TRUE(file.check().empty());
}

TEST(SiteFile, ADamagedEditIsNamedAndCanBeUndone) {
  const TempDir folder;
  const std::string path = made_site(folder, passage_record());
  add_edits(path);
  {
    SqliteDatabase database(path, {.access = SqliteAccess::kWrite});
    database.run("UPDATE edits SET polygon = '0,0 1,x 2,2' WHERE id = 2");
  }
  SiteFile file(path, SiteAccess::kWrite);
  EXPECT_EQ(file.sessions().size(), 2U);
  const std::vector<std::string> problems = file.check();
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0], HasSubstr("edit 2 is damaged: '1,x' is no corner"));
  EXPECT_THAT(problems[0], HasSubstr("loopstone site edit --undo 2"));
  file.begin_change();
  EXPECT_TRUE(file.remove_edit(2));
  file.commit();
  EXPECT_TRUE(file.check().empty());
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
