#include "loopstone/formats/site_file.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "formats/packed_record.hpp"
#include "formats/sqlite_database.hpp"
#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"

namespace loopstone {

namespace {

/// "lpst", of SQLite's list of what a file may be.
constexpr int kApplication = 0x6c707374;
constexpr int kSchema = 2;
/// The first with edits.
constexpr int kSchemaOfEdits = 2;

/// What leads from each version of the schema to the next; a new site begins with the first.
constexpr const char* kMigrations[kSchema] = {
    R"(
CREATE TABLE site (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE robots (id INTEGER PRIMARY KEY, toml TEXT NOT NULL UNIQUE);
CREATE TABLE sessions (
  id INTEGER PRIMARY KEY AUTOINCREMENT, digest TEXT NOT NULL UNIQUE, log TEXT NOT NULL,
  begins_ns INTEGER NOT NULL, added TEXT NOT NULL, robot INTEGER NOT NULL REFERENCES robots(id),
  status TEXT NOT NULL CHECK (status IN ('joined', 'pending', 'refused', 'retired')),
  reason TEXT NOT NULL, closures INTEGER NOT NULL, scans INTEGER NOT NULL, path_m REAL NOT NULL,
  duration_s REAL NOT NULL, verdict TEXT NOT NULL, sentence TEXT NOT NULL);
CREATE INDEX sessions_in_order ON sessions (begins_ns, digest);
CREATE TABLE records (
  session INTEGER PRIMARY KEY REFERENCES sessions(id) ON DELETE CASCADE,
  version INTEGER NOT NULL, record BLOB NOT NULL);
CREATE TABLE placements (
  session INTEGER PRIMARY KEY REFERENCES sessions(id) ON DELETE CASCADE, placement BLOB NOT NULL);
CREATE TABLE pairs (
  older INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  newer INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  closures INTEGER NOT NULL, pair BLOB NOT NULL, PRIMARY KEY (older, newer)) WITHOUT ROWID;
CREATE INDEX pairs_of_newer ON pairs (newer);
CREATE TABLE events (
  id INTEGER PRIMARY KEY, at TEXT NOT NULL, what TEXT NOT NULL, session TEXT NOT NULL,
  text TEXT NOT NULL);
)",
    R"(
CREATE TABLE edits (
  id INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('exclude', 'free', 'wall', 'unknown')),
  excluded INTEGER UNIQUE REFERENCES sessions(id) ON DELETE CASCADE,
  anchor INTEGER REFERENCES sessions(id) ON DELETE SET NULL, submap INTEGER NOT NULL,
  polygon TEXT NOT NULL, CHECK ((kind = 'exclude') = (excluded IS NOT NULL)));
)"};

template <typename Value>
std::string packed(const Value& value) {
  ByteWriter writer;
  writer(value);
  return pack_record(writer.take());
}

template <typename Value>
Value unpacked(std::span<const char> bytes, const Location& where) {
  Value value;
  const std::string content = unpack_record(bytes);
  ByteReader reader(content, where);
  reader(value);
  reader.end();
  return value;
}

bool has_record(const SiteSession& session) {
  return session.status != SessionStatus::kRefused && session.status != SessionStatus::kRetired;
}

std::string name_of(const SiteSession& session) {
  return fmt::format("session {} ({})", session.id, session.log);
}

}  // namespace

struct SiteFile::State {
  std::string path;
  std::string options_toml;
  mutable SqliteDatabase database;
  bool changes = false;

  State(std::string file, SqliteAccess access)
      : path(std::move(file)),
        database(path, {.access = access, .most_value_bytes = 1'000'000'000}) {}

  [[noreturn]] void fail(const std::string& reason) const { throw DataError({path}, reason); }
  [[noreturn]] void fail(const SqliteError& error) const {
    if (error.code() == SQLITE_FULL) fail("the disk is full; the site stays as it was");
    if (error.code() == SQLITE_CORRUPT || error.code() == SQLITE_NOTADB)
      fail(fmt::format("this site is damaged ({}); `loopstone site check` tells what is lost",
                       error.what()));
    if (error.code() == SQLITE_READONLY || error.code() == SQLITE_CANTOPEN)
      fail(fmt::format("can't be written ({})", error.what()));
    fail(error.what());
  }
  /// What SQLite throws as what this class promises.
  template <typename Work>
  auto told(Work&& work) const {
    try {
      return work();
    } catch (const SqliteError& error) {
      fail(error);
    }
  }

  std::int64_t number(const std::string& sql) const {
    SqliteStatement statement(database, sql);
    return statement.step() ? statement.integer(0) : 0;
  }
  /// A site that is only read may be of an older program.
  [[nodiscard]] bool has_edits() const { return number("PRAGMA user_version") >= kSchemaOfEdits; }
  void migrate() {
    const auto version = number("PRAGMA user_version");
    if (version == kSchema) return;
    database.run("BEGIN IMMEDIATE");
    for (auto step = number("PRAGMA user_version"); step < kSchema; ++step)
      database.run(kMigrations[step]);
    database.run(fmt::format("PRAGMA user_version = {}; PRAGMA application_id = {}; COMMIT",
                             kSchema, kApplication));
  }
};

void SiteFile::create(const std::string& path, const std::string& options_toml) {
  if (std::filesystem::exists(path)) throw DataError({path}, "is there already");
  // Made beside it and renamed, so that there is never half a site.
  const std::string making = path + ".new";
  std::filesystem::remove(making);
  try {
    // The room of what is removed is to be given back at once, which is of a file's first page.
    SqliteDatabase first(making, {.access = SqliteAccess::kCreate});
    first.run(fmt::format("PRAGMA auto_vacuum = FULL; PRAGMA application_id = {}", kApplication));
  } catch (const SqliteError& error) {
    throw DataError({path}, fmt::format("can't be written: {}", error.what()));
  }
  {
    State state(making, SqliteAccess::kWrite);
    state.told([&] {
      state.migrate();
      SqliteStatement insert(state.database, "INSERT INTO site VALUES (?, ?)");
      const std::pair<std::string, std::string> facts[] = {{"options", options_toml},
                                                           {"made_by", std::string(kVersion)}};
      for (const auto& [key, value] : facts) {
        insert.bind_text(1, key);
        insert.bind_text(2, value);
        (void)insert.step();
        insert.reset();
      }
      state.database.run("PRAGMA wal_checkpoint(TRUNCATE)");
    });
  }
  std::error_code error;
  std::filesystem::rename(making, path, error);
  if (error) throw DataError({path}, "can't be written: " + error.message());
}

bool SiteFile::create_where_missing(const std::string& path, const std::string& options_toml) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return false;
  create(path, options_toml);
  return true;
}

bool is_site(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  try {
    SqliteDatabase database(path, {.access = SqliteAccess::kUntouched});
    SqliteStatement statement(database, "PRAGMA application_id");
    return statement.step() && statement.integer(0) == kApplication;
  } catch (const SqliteError&) {
    return false;
  }
}

SiteFile::SiteFile(const std::string& path, SiteAccess access) {
  if (!std::filesystem::exists(path))
    throw DataError({path}, "there is no such site; `loopstone site add` makes it");
  try {
    state_ = std::make_unique<State>(
        path, access == SiteAccess::kWrite ? SqliteAccess::kWrite : SqliteAccess::kRead);
    State& state = *state_;
    if (state.number("PRAGMA application_id") != kApplication)
      state.fail("this is no site of loopstone");
    const auto version = state.number("PRAGMA user_version");
    if (version > kSchema) {
      state.fail(
          fmt::format("this site was written by a newer loopstone (schema {}, this program "
                      "knows {}); update loopstone",
                      version, kSchema));
    }
    if (access == SiteAccess::kWrite) state.migrate();
    SqliteStatement options(state.database, "SELECT value FROM site WHERE key = 'options'");
    if (options.step()) state.options_toml = options.text(0);
  } catch (const SqliteError& error) {
    if (error.code() == SQLITE_NOTADB) throw DataError({path}, "this is no site of loopstone");
    throw DataError({path}, fmt::format("this site can't be read: {}", error.what()));
  }
}

SiteFile::~SiteFile() {
  if (!state_->changes) return;
  try {
    state_->database.run("ROLLBACK");
  } catch (const std::exception&) {
    return;  // SQLite does it when the file is closed
  }
}

const std::string& SiteFile::path() const { return state_->path; }
const std::string& SiteFile::options_toml() const { return state_->options_toml; }

std::vector<SiteSession> SiteFile::sessions() const {
  return state_->told([&] {
    const char* const excluded_by =
        state_->has_edits() ? "(SELECT e.id FROM edits e WHERE e.excluded = s.id)" : "NULL";
    SqliteStatement rows(state_->database,
                         fmt::format("SELECT s.id, log, digest, begins_ns, added, toml, status, "
                                     "reason, closures, scans, path_m, duration_s, verdict, "
                                     "sentence, {} FROM sessions s JOIN robots r ON s.robot = r.id "
                                     "ORDER BY begins_ns, digest",
                                     excluded_by));
    std::vector<SiteSession> sessions;
    while (rows.step()) {
      SiteSession session{.id = rows.integer(0),
                          .log = std::string(rows.text(1)),
                          .digest = std::string(rows.text(2)),
                          .begins = {rows.integer(3)},
                          .added = std::string(rows.text(4)),
                          .robot = std::string(rows.text(5)),
                          .reason = std::string(rows.text(7)),
                          .closures = static_cast<int>(rows.integer(8)),
                          .scans = rows.integer(9),
                          .path_m = rows.real(10),
                          .duration_s = rows.real(11),
                          .verdict = std::string(rows.text(12)),
                          .sentence = std::string(rows.text(13))};
      const auto status = find_word<SessionStatus>(rows.text(6));
      if (!status) state_->fail(fmt::format("{} has a status that there is not", name_of(session)));
      session.status = *status;
      // The row says what it would be without.
      if (!rows.is_null(14)) {
        session.status = SessionStatus::kExcluded;
        session.reason = fmt::format("left out by edit {}", rows.integer(14));
      }
      sessions.push_back(std::move(session));
    }
    return sessions;
  });
}

std::vector<SiteEdit> SiteFile::edits() const {
  return state_->told([&] {
    std::vector<SiteEdit> edits;
    if (!state_->has_edits()) return edits;
    SqliteStatement rows(state_->database,
                         "SELECT id, at, kind, excluded, anchor, submap, polygon FROM edits "
                         "ORDER BY id");
    while (rows.step()) {
      SiteEdit edit{
          .id = rows.integer(0), .at = std::string(rows.text(1)), .excluded = rows.integer(3)};
      if (!rows.is_null(4)) edit.anchor = {rows.integer(4), rows.integer(5)};
      try {
        const auto kind = find_word<SiteEditKind>(rows.text(2));
        if (!kind) throw UsageError("a kind that there is not");
        edit.kind = *kind;
        if (edit.kind != SiteEditKind::kExclude) edit.polygon = parse_polygon(rows.text(6));
      } catch (const UsageError& error) {
        state_->fail(
            fmt::format("edit {} is damaged: {}; `loopstone site edit --undo {}` removes "
                        "it, and it can be done again",
                        edit.id, error.what(), edit.id));
      }
      edits.push_back(std::move(edit));
    }
    return edits;
  });
}

std::vector<SiteEvent> SiteFile::events() const {
  return state_->told([&] {
    SqliteStatement rows(state_->database,
                         "SELECT at, what, session, text FROM events ORDER BY id");
    std::vector<SiteEvent> events;
    while (rows.step()) {
      events.push_back({std::string(rows.text(0)), std::string(rows.text(1)),
                        std::string(rows.text(2)), std::string(rows.text(3))});
    }
    return events;
  });
}

std::shared_ptr<const DriveRecord> SiteFile::record(const SiteSession& session) const {
  return state_->told([&] {
    SqliteStatement rows(state_->database, "SELECT version, record FROM records WHERE session = ?");
    rows.bind(1, session.id);
    if (!rows.step()) state_->fail(fmt::format("of {} nothing is kept", name_of(session)));
    if (rows.integer(0) != DriveRecord::kVersion) {
      state_->fail(
          fmt::format("{} is kept in version {} of its form, and this program reads {}; "
                      "make the site anew from its logs",
                      name_of(session), rows.integer(0), DriveRecord::kVersion));
    }
    std::shared_ptr<const DriveRecord> record;
    try {
      record =
          std::make_shared<const DriveRecord>(unpacked<DriveRecord>(rows.blob(1), {state_->path}));
    } catch (const std::runtime_error& error) {
      state_->fail(
          fmt::format("{} is damaged: {}; `loopstone site prune --session {}` removes it, "
                      "and its log can be added again",
                      name_of(session), error.what(), session.id));
    }
    constexpr double kReachM = 1e4;
    if (!is_sound(*record, kReachM))
      state_->fail(fmt::format("{} contradicts itself", name_of(session)));
    return record;
  });
}

std::vector<SitePair> SiteFile::pairs() const {
  return state_->told([&] {
    SqliteStatement rows(state_->database,
                         "SELECT older, newer, pair FROM pairs ORDER BY newer, older");
    std::vector<SitePair> pairs;
    while (rows.step()) {
      SitePair pair{.older = rows.integer(0), .newer = rows.integer(1)};
      try {
        pair.pair = unpacked<DrivePair>(rows.blob(2), {state_->path});
      } catch (const std::runtime_error& error) {
        state_->fail(
            fmt::format("what ties sessions {} and {} is damaged: {}; `loopstone site "
                        "rebuild` finds it again",
                        pair.older, pair.newer, error.what()));
      }
      pairs.push_back(std::move(pair));
    }
    return pairs;
  });
}

std::vector<SitePlacement> SiteFile::placements() const {
  return state_->told([&] {
    SqliteStatement rows(state_->database, "SELECT session, placement FROM placements");
    std::vector<SitePlacement> placements;
    while (rows.step()) {
      SitePlacement placement{.session = rows.integer(0)};
      try {
        placement.placement = unpacked<DrivePlacement>(rows.blob(1), {state_->path});
      } catch (const std::runtime_error& error) {
        state_->fail(
            fmt::format("where session {} lies is damaged: {}; `loopstone site rebuild` "
                        "finds it again",
                        placement.session, error.what()));
      }
      placements.push_back(std::move(placement));
    }
    return placements;
  });
}

void SiteFile::begin_change(const std::function<bool()>& waiting) {
  constexpr auto kPause = std::chrono::milliseconds(100);
  while (true) {
    try {
      state_->database.run("BEGIN IMMEDIATE");
      state_->changes = true;
      return;
    } catch (const SqliteError& error) {
      if (error.code() != SQLITE_BUSY) state_->fail(error);
    }
    if (waiting && !waiting())
      throw UsageError(state_->path + ": another program is writing this site");
    std::this_thread::sleep_for(kPause);
  }
}

std::int64_t SiteFile::add(const SiteSession& session, const DriveRecord* record) {
  return state_->told([&] {
    SqliteDatabase& database = state_->database;
    SqliteStatement robot(database, "INSERT OR IGNORE INTO robots (toml) VALUES (?)");
    robot.bind_text(1, session.robot);
    (void)robot.step();
    SqliteStatement row(database,
                        "INSERT INTO sessions (digest, log, begins_ns, added, robot, status, "
                        "reason, closures, scans, path_m, duration_s, verdict, sentence) VALUES "
                        "(?, ?, ?, ?, (SELECT id FROM robots WHERE toml = ?), ?, ?, ?, ?, ?, ?, ?, "
                        "?)");
    row.bind_text(1, session.digest);
    row.bind_text(2, session.log);
    row.bind(3, session.begins.nanoseconds);
    row.bind_text(4, session.added);
    row.bind_text(5, session.robot);
    row.bind_text(6, to_string(session.status));
    row.bind_text(7, session.reason);
    row.bind(8, session.closures);
    row.bind(9, session.scans);
    row.bind_real(10, session.path_m);
    row.bind_real(11, session.duration_s);
    row.bind_text(12, session.verdict);
    row.bind_text(13, session.sentence);
    (void)row.step();
    const std::int64_t id = sqlite3_last_insert_rowid(database.handle());
    if (record == nullptr) return id;
    const std::string bytes = packed(*record);
    SqliteStatement insert(database, "INSERT INTO records VALUES (?, ?, ?)");
    insert.bind(1, id);
    insert.bind(2, DriveRecord::kVersion);
    insert.bind_blob(3, bytes);
    (void)insert.step();
    return id;
  });
}

void SiteFile::update(const SiteSession& session) {
  state_->told([&] {
    SqliteStatement row(state_->database,
                        "UPDATE sessions SET status = ?, reason = ?, closures = ? WHERE id = ?");
    row.bind_text(1, to_string(session.status));
    row.bind_text(2, session.reason);
    row.bind(3, session.closures);
    row.bind(4, session.id);
    (void)row.step();
  });
}

void SiteFile::drop_record(std::int64_t session) {
  state_->told([&] {
    state_->database.run(
        fmt::format("DELETE FROM records WHERE session = {0};"
                    "DELETE FROM placements WHERE session = {0};"
                    "DELETE FROM pairs WHERE older = {0} OR newer = {0};",
                    session));
  });
}

void SiteFile::remove(std::int64_t session) {
  state_->told(
      [&] { state_->database.run(fmt::format("DELETE FROM sessions WHERE id = {}", session)); });
}

void SiteFile::set_joins(const std::vector<SitePair>& pairs,
                         const std::vector<SitePlacement>& placements) {
  state_->told([&] {
    state_->database.run("DELETE FROM pairs; DELETE FROM placements;");
    SqliteStatement pair_row(state_->database, "INSERT INTO pairs VALUES (?, ?, ?, ?)");
    for (const SitePair& pair : pairs) {
      const std::string bytes = packed(pair.pair);
      pair_row.bind(1, pair.older);
      pair_row.bind(2, pair.newer);
      pair_row.bind(3, pair.pair.standing());
      pair_row.bind_blob(4, bytes);
      (void)pair_row.step();
      pair_row.reset();
    }
    SqliteStatement place_row(state_->database, "INSERT INTO placements VALUES (?, ?)");
    for (const SitePlacement& placement : placements) {
      const std::string bytes = packed(placement.placement);
      place_row.bind(1, placement.session);
      place_row.bind_blob(2, bytes);
      (void)place_row.step();
      place_row.reset();
    }
  });
}

std::int64_t SiteFile::add_edit(const SiteEdit& edit) {
  return state_->told([&] {
    SqliteStatement row(state_->database,
                        "INSERT INTO edits (at, kind, excluded, anchor, submap, polygon) VALUES "
                        "(?, ?, nullif(?, 0), nullif(?, 0), ?, ?)");
    const SiteAnchor anchor = edit.anchor.value_or(SiteAnchor{});
    const std::string corners = polygon_text(edit.polygon);
    row.bind_text(1, edit.at);
    row.bind_text(2, to_string(edit.kind));
    row.bind(3, edit.excluded);
    row.bind(4, anchor.session);
    row.bind(5, anchor.submap);
    row.bind_text(6, corners);
    (void)row.step();
    return sqlite3_last_insert_rowid(state_->database.handle());
  });
}

void SiteFile::set_place(std::int64_t edit, const std::optional<SiteAnchor>& anchor,
                         const Polygon2& polygon) {
  state_->told([&] {
    SqliteStatement row(state_->database,
                        "UPDATE edits SET anchor = nullif(?, 0), submap = ?, polygon = ? WHERE "
                        "id = ?");
    const SiteAnchor at = anchor.value_or(SiteAnchor{});
    const std::string corners = polygon_text(polygon);
    row.bind(1, at.session);
    row.bind(2, at.submap);
    row.bind_text(3, corners);
    row.bind(4, edit);
    (void)row.step();
  });
}

bool SiteFile::remove_edit(std::int64_t edit) {
  return state_->told([&] {
    state_->database.run(fmt::format("DELETE FROM edits WHERE id = {}", edit));
    return sqlite3_changes(state_->database.handle()) > 0;
  });
}

void SiteFile::add_event(const SiteEvent& event) {
  state_->told([&] {
    SqliteStatement row(state_->database,
                        "INSERT INTO events (at, what, session, text) VALUES (?, ?, ?, ?)");
    row.bind_text(1, event.at);
    row.bind_text(2, event.what);
    row.bind_text(3, event.session);
    row.bind_text(4, event.text);
    (void)row.step();
  });
}

void SiteFile::commit() {
  state_->told([&] { state_->database.run("COMMIT"); });
  state_->changes = false;
}

std::vector<std::string> SiteFile::check() const {
  std::vector<std::string> problems;
  const auto ask = [&](const std::string& sql, const auto& tell) {
    try {
      SqliteStatement rows(state_->database, sql);
      while (rows.step()) tell(rows);
    } catch (const SqliteError& error) {
      problems.emplace_back(error.what());
    }
  };
  ask("PRAGMA integrity_check(20)", [&](const SqliteStatement& row) {
    if (row.text(0) != "ok") problems.emplace_back(row.text(0));
  });
  ask("PRAGMA foreign_key_check", [&](const SqliteStatement& row) {
    problems.push_back(
        fmt::format("table {} speaks of a row of {} that is not there", row.text(0), row.text(2)));
  });
  const auto try_out = [&](const auto& read) {
    try {
      read();
    } catch (const DataError& error) {
      problems.emplace_back(error.what());
    }
  };
  try_out([&] { (void)edits(); });
  std::vector<SiteSession> sessions_here;
  try_out([&] { sessions_here = sessions(); });
  for (const SiteSession& session : sessions_here) {
    if (has_record(session)) try_out([&] { (void)record(session); });
  }
  try_out([&] { (void)pairs(); });
  try_out([&] { (void)placements(); });
  return problems;
}

std::int64_t SiteFile::bytes() const {
  std::int64_t bytes = 0;
  for (const char* end : {"", "-wal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(state_->path + end, error);
    if (!error) bytes += static_cast<std::int64_t>(size);
  }
  return bytes;
}

void SiteFile::compact() {
  state_->told([&] { state_->database.run("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)"); });
}

}  // namespace loopstone
