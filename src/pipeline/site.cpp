#include "loopstone/pipeline/site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/mapping/glass_survey.hpp"
#include "loopstone/pipeline/log_mapping.hpp"
#include "loopstone/sensor/log_digest.hpp"
#include "mapping/glass_evidence.hpp"
#include "pipeline/site_books.hpp"
#include "pipeline/site_corrections.hpp"

namespace loopstone {

namespace {

/// Keeps what a mapping has led to, before its end.
class RecordKeeper : public MappingWatch {
 public:
  void begin(Mapper& /*mapper*/, const RobotModel& /*robot*/, bool /*anew*/) override {
    digest_ = {};
  }
  void add(const SensorMessage& message, Mapper& mapper) override {
    digest_.add(message);
    mapper.add(message);
  }
  void finishing(Mapper& mapper) override {
    (void)mapper.judge_robot();  // ends the drive
    state_ = mapper.save_state().get();
  }

  [[nodiscard]] const LogDigest& digest() const { return digest_; }
  [[nodiscard]] DriveRecord take_record(const MapOptions& options) {
    return record_of(std::move(state_), options);
  }

 private:
  LogDigest digest_{};
  MapperState state_{};
};

/// Why a drive is not joined, by what was found of it.
std::string why_pending(const JoinedDrives& drives, std::size_t drive) {
  bool waits = false;
  bool is_alike = false;
  bool differs = false;
  bool was_laid = false;
  for (const DrivePair& pair : drives.pairs()) {
    if (pair.older == pair.newer || (pair.older != drive && pair.newer != drive)) continue;
    for (const LoopClosure& closure : pair.closures) {
      was_laid = was_laid || (closure.state == ClosureState::kRevoked &&
                              closure.reason == ClosureReason::kSurroundings);
      waits = waits || closure.state == ClosureState::kWaiting || closure.stands();
      is_alike = is_alike || closure.reason == ClosureReason::kAmbiguousPlace ||
                 closure.reason == ClosureReason::kAmbiguousPose;
      differs = differs || closure.reason == ClosureReason::kSurroundings;
    }
  }
  if (was_laid)
    return "it looks like a place of the site and is another one: laid on it, their walls do not "
           "fit";
  if (is_alike) return "it looks like several places of the site: which of them is not known";
  if (waits) return "one place looks like one of the site, and no second one bears it out";
  if (differs) return "a place looks like one of the site, and what lies around it does not";
  return "nothing of it was recognised";
}

int closures_with_others(const JoinedDrives& drives, std::size_t drive) {
  int count = 0;
  for (const DrivePair& pair : drives.pairs()) {
    if (pair.older != pair.newer && (pair.older == drive || pair.newer == drive))
      count += pair.standing();
  }
  return count;
}

using Squares = std::set<std::pair<int, int>>;

/// Where a drive went.
Squares squares_of(const DriveRecord& drive, const DrivePlacement& placement) {
  Squares squares;
  const auto& submaps = drive.back_end.chain.submaps;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const Pose2 map_T_local =
        placement.map_T_submaps[i] * submaps[i].keys.front().local_T_robot.inverse();
    for (const KeyScan& key : submaps[i].keys) {
      const Eigen::Vector2d at = map_T_local * key.local_T_robot.translation();
      squares.emplace(static_cast<int>(std::floor(at.x() / kSite.visit_cell_m)),
                      static_cast<int>(std::floor(at.y() / kSite.visit_cell_m)));
    }
  }
  return squares;
}

/// Of each drive; nothing of those that are not joined.
std::vector<Squares> squares_of(const JoinedDrives& drives) {
  std::vector<Squares> squares(drives.size());
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (drives.is_joined(i)) squares[i] = squares_of(drives.record(i), drives.placements()[i]);
  }
  return squares;
}

bool was_there(const Squares& squares, const std::pair<int, int>& square) {
  for (int x = square.first - 1; x <= square.first + 1; ++x) {
    for (int y = square.second - 1; y <= square.second + 1; ++y)
      if (squares.contains({x, y})) return true;
  }
  return false;
}

/// Whether so many newer drives came by wherever this one went.
bool is_worn_out(std::size_t drive, std::span<const Squares> squares) {
  return std::ranges::all_of(squares[drive], [&](const auto& square) {
    int visits = 0;
    for (std::size_t newer = drive + 1; newer < squares.size(); ++newer)
      visits += was_there(squares[newer], square) ? 1 : 0;
    return visits >= kSite.keep_visits;
  });
}

/// Tells how far it is. Throws UsageError when it is called off.
void tell(const ProgressCallback& progress, const Progress& news, const SiteFile& file) {
  if (progress && !progress(news)) throw UsageError(file.path() + ": was called off");
}

std::function<bool()> as_question(const ProgressCallback& progress, const Progress& news) {
  if (!progress) return {};
  return [&progress, news] { return progress(news); };
}

bool is_kept(const SiteSession& session) {
  return session.status == SessionStatus::kJoined || session.status == SessionStatus::kPending;
}

double footprint_m(const SiteSession& session) {
  return parse_robot(session.robot, session.log).footprint_radius_m;
}

/// Of the oldest sessions of a map, as many as the ledger has visits.
SiteGrids grids_of(const VisitLedger& ledger, const GlassSurvey& glass, const SiteMap& map) {
  const GridFrame& frame = ledger.cells().frame();
  const std::vector<Trajectory> paths = map.result.trajectories();
  std::vector<Stamp> begins;
  Travel travel(frame);
  for (std::size_t i = 0; i < ledger.visits(); ++i) {
    const SiteSession& session = map.sessions[i];
    begins.push_back(session.begins);
    travel.add(paths[i], footprint_m(session));
  }
  return {.coverage = coverage_of(ledger, std::move(begins)),
          .travel = travel.cells(),
          .glass = glass.probability(frame)};
}

bool comes_before(const SiteSession& a, const SiteSession& b) {
  return std::pair(a.begins, a.digest) < std::pair(b.begins, b.digest);
}

int newer_than(const SiteSession& session, std::span<const SiteSession> all) {
  return static_cast<int>(std::ranges::count_if(
      all, [&](const SiteSession& other) { return comes_before(session, other); }));
}

}  // namespace

std::vector<NumberGroup> site_numbers() {
  return {number_group("visit_ledger", kVisitLedger), number_group("travel", kTravel),
          number_group("glass_survey", kGlassSurvey),
          number_group("glass_evidence", kGlassEvidence), number_group("site", kSite)};
}

MappedSession map_session(const LogSource& source, LogReader& reader, const LogCut& cut,
                          const MapOptions& options, Threads threads, std::optional<Stamp> begins,
                          const ReadingWatch& watch) {
  RecordKeeper keeper;
  const LogMap made = map_log(source, reader, cut, options, threads, watch, &keeper);
  const MapResult& result = made.result;
  MappedSession mapped{.complete = result.complete};
  SiteSession& session = mapped.session;
  session.log = source.path;
  session.digest = keeper.digest().text();
  session.robot = robot_to_toml(made.robot);
  session.begins =
      begins ? *begins : (result.trajectory.empty() ? Stamp{} : result.trajectory.front().stamp);
  session.added = now_text();
  session.scans = result.statistics.scans;
  session.path_m = result.statistics.path_length_m;
  session.duration_s = result.statistics.duration_s;
  session.verdict = to_string(result.verdict.overall);
  session.sentence = result.verdict.sentence;
  DriveRecord record = keeper.take_record(options);
  if (result.verdict.overall == Verdict::kBad || record.back_end.chain.submaps.empty()) {
    session.status = SessionStatus::kRefused;
    session.reason = "its own map is bad: " + session.sentence;
  } else if (mapped.complete) {
    mapped.record = std::make_shared<const DriveRecord>(std::move(record));
  }
  return mapped;
}

Site::Site(const std::string& path, SiteAccess access, Threads threads)
    : file_(path, access), threads_(threads) {
  const auto problems = apply_toml(list_options(options_), file_.options_toml(), path);
  if (!problems.empty()) throw OptionsError(problems);
}

Site::Kept Site::load(std::optional<std::int64_t> without, const ProgressCallback& progress) const {
  Kept kept{.sessions = file_.sessions(), .drives = JoinedDrives(options_, threads_)};
  std::erase_if(kept.sessions,
                [&](const SiteSession& s) { return !is_kept(s) || s.id == without; });
  std::map<std::int64_t, std::size_t> places;
  std::vector<std::shared_ptr<const DriveRecord>> records;
  for (const SiteSession& session : kept.sessions) {
    tell(progress, {"reading", std::ssize(records), std::ssize(kept.sessions)}, file_);
    places[session.id] = records.size();
    records.push_back(file_.record(session));
  }
  std::vector<DrivePlacement> placements(records.size());
  for (SitePlacement& placement : file_.placements()) {
    if (places.contains(placement.session))
      placements[places[placement.session]] = std::move(placement.placement);
  }
  std::vector<DrivePair> pairs;
  for (SitePair& pair : file_.pairs()) {
    if (!places.contains(pair.older) || !places.contains(pair.newer)) continue;
    pair.pair.older = places[pair.older];
    pair.pair.newer = places[pair.newer];
    pairs.push_back(std::move(pair.pair));
  }
  std::ranges::stable_sort(pairs, {},
                           [](const DrivePair& p) { return std::pair(p.newer, p.older); });
  kept.drives.restore(std::move(records), std::move(pairs), std::move(placements));
  return kept;
}

Site::Kept Site::join_all(const std::vector<SiteSession>& sessions, const SiteWatch& watch) const {
  Kept kept{.sessions = sessions, .drives = JoinedDrives(options_, threads_)};
  std::erase_if(kept.sessions, [](const SiteSession& session) { return !is_kept(session); });
  for (const SiteSession& session : kept.sessions) {
    const Progress news{"joining", std::ssize(kept.drives), std::ssize(kept.sessions)};
    kept.drives.add(file_.record(session), as_question(watch.progress, news));
    tell(watch.progress, news, file_);
  }
  return kept;
}

void Site::store(Kept& kept, const Places& before) {
  std::vector<SitePair> pairs;
  for (const DrivePair& pair : kept.drives.pairs())
    pairs.push_back({kept.sessions[pair.older].id, kept.sessions[pair.newer].id, pair});
  std::vector<SitePlacement> placements;
  for (std::size_t i = 0; i < kept.sessions.size(); ++i) {
    SiteSession& session = kept.sessions[i];
    placements.push_back({session.id, kept.drives.placements()[i]});
    const bool is_joined = kept.drives.is_joined(i);
    session.status = is_joined ? SessionStatus::kJoined : SessionStatus::kPending;
    session.reason = is_joined ? "" : why_pending(kept.drives, i);
    session.closures = closures_with_others(kept.drives, i);
    file_.update(session);
  }
  file_.set_joins(pairs, placements);
  keep_edits_in_place(before);
}

/// All sessions are joined anew.
void Site::rejoin(const Places& before, const SiteWatch& watch) {
  Kept kept = join_all(file_.sessions(), watch);
  store(kept, before);
}

void Site::retire(SiteSession session, int closures, std::string reason) {
  session.status = SessionStatus::kRetired;
  session.reason = std::move(reason);
  session.closures = closures;
  file_.update(session);
  file_.drop_record(session.id);
}

/// Those that nothing ties to any other, though they were compared with many newer ones.
void Site::give_up_waiting(Kept& kept) {
  std::vector<SiteSession> all = file_.sessions();
  std::erase_if(all, [](const SiteSession& session) {
    return session.status == SessionStatus::kRefused || session.status == SessionStatus::kExcluded;
  });
  for (std::size_t i = 0; i < kept.sessions.size();) {
    const bool waits = !kept.drives.is_joined(i) && closures_with_others(kept.drives, i) == 0 &&
                       newer_than(kept.sessions[i], all) >= kSite.keep_pending;
    if (!waits) {
      ++i;
      continue;
    }
    retire(kept.sessions[i], 0,
           fmt::format("it was compared with {} newer ones, and nothing told where it belongs",
                       kSite.keep_pending));
    kept.sessions.erase(kept.sessions.begin() + static_cast<std::ptrdiff_t>(i));
    kept.drives.remove(i);
  }
}

/// The oldest first, as long as newer ones show all that they saw and hold together without them.
void Site::retire_worn_out(Kept& kept) {
  const std::vector<SiteSession> all = file_.sessions();
  const auto joined = [](const JoinedDrives& drives) {
    return std::ranges::count_if(drives.placements(), &DrivePlacement::is_joined);
  };
  for (std::size_t i = 0; i < kept.sessions.size();) {
    const int enough =
        kept.drives.shows_something_alone(i) ? kSite.keep_shown_alone : kSite.keep_visits;
    if (!kept.drives.is_joined(i) || newer_than(kept.sessions[i], all) < enough ||
        !is_worn_out(i, squares_of(kept.drives))) {
      ++i;
      continue;
    }
    JoinedDrives rest = kept.drives;
    rest.remove(i);
    if (joined(rest) + 1 < joined(kept.drives)) {
      ++i;
      continue;
    }
    retire(kept.sessions[i], closures_with_others(kept.drives, i),
           fmt::format("{} newer ones came by wherever it drove", kSite.keep_visits));
    kept.sessions.erase(kept.sessions.begin() + static_cast<std::ptrdiff_t>(i));
    kept.drives = std::move(rest);
  }
}

void Site::note(const std::string& what, const std::string& session, const std::string& text) {
  file_.add_event({now_text(), what, session, text});
}

SiteSession Site::add(const MappedSession& mapped, const SiteWatch& watch) {
  const Places places = begin_change(watch);
  SiteSession session = mapped.session;
  std::vector<SiteSession> before = file_.sessions();
  for (const SiteSession& other : before) {
    if (other.digest == session.digest) {
      throw UsageError(fmt::format("{}: is in the site already, as session {} ({})", session.log,
                                   other.id, other.log));
    }
  }
  session.id = file_.add(session, mapped.record.get());
  if (mapped.record) {
    const bool is_newest = std::ranges::all_of(before, [&](const SiteSession& other) {
      return !is_kept(other) || comes_before(other, session);
    });
    Kept kept = is_newest ? load(session.id, watch.progress) : join_all(file_.sessions(), watch);
    if (is_newest) {
      const Progress news{"joining", std::ssize(kept.sessions), std::ssize(kept.sessions) + 1};
      kept.drives.add(mapped.record, as_question(watch.progress, news));
      kept.sessions.push_back(session);
      tell(watch.progress, news, file_);
    }
    give_up_waiting(kept);
    retire_worn_out(kept);
    store(kept, places);
    std::vector<SiteSession> after = file_.sessions();
    session = find_session(after, session.id, file_.path());
  }
  note("add", session.log,
       session.status == SessionStatus::kJoined
           ? fmt::format("joined by {} closures", session.closures)
           : fmt::format("{}: {}", to_string(session.status), session.reason));
  file_.commit();
  return session;
}

void Site::remove(const std::vector<std::int64_t>& sessions, const SiteWatch& watch) {
  const Places places = begin_change(watch);
  std::vector<SiteSession> known = file_.sessions();
  for (const std::int64_t id : sessions) {
    note("remove", find_session(known, id, file_.path()).log, "");
    file_.remove(id);
  }
  // Those that are left are joined by what was found between them alone.
  rejoin(places, watch);
  file_.commit();
}

void Site::rebuild(const SiteWatch& watch) {
  const Places places = begin_change(watch);
  Kept kept = join_all(file_.sessions(), watch);
  store(kept, places);
  note("rebuild", "", fmt::format("{} sessions", kept.sessions.size()));
  file_.commit();
}

/// The map that the sessions hold together which are joined; what each of them saw goes to `take`,
/// in order, and to nothing else.
SiteMap Site::draw(const Kept& kept, const ProgressCallback& progress,
                   const TakeSession& take) const {
  SiteMap map;
  for (std::size_t i = 0; i < kept.sessions.size(); ++i)
    if (kept.drives.is_joined(i)) map.sessions.push_back(kept.sessions[i]);
  if (map.sessions.empty()) throw DataError({file_.path()}, "there is no session in this site yet");
  const RobotModel robot = parse_robot(map.sessions.back().robot, file_.path());
  map.result = kept.drives.finish(
      robot, [&](const DriveVisit& visit) { take(map.sessions[visit.drive], visit); }, progress);
  if (!map.result.complete) throw UsageError(file_.path() + ": was called off");
  if (!map.result.map_failure.empty()) throw DataError({file_.path()}, map.result.map_failure);
  return map;
}

SiteMap Site::map(std::optional<Stamp> until, const SiteExtras& extras,
                  const ProgressCallback& progress) const {
  const Kept kept = load({}, progress);
  VisitLedger ledger;
  GlassSurvey glass;
  SiteMap map = draw(kept, progress, [&](const SiteSession& session, const DriveVisit& visit) {
    if (until && *until < session.begins) return;
    ledger.add(visit.map);
    if (extras.grids) glass.add(visit.scans, footprint_m(session), threads_);
  });
  if (ledger.visits() == 0)
    throw DataError({file_.path()},
                    fmt::format("no session in this site is as old as {}", utc_text(*until)));
  map.result.map = ledger.map();
  map.movable = ledger.movable();
  map.edits = corrections_on(kept);
  correct(map.result.map, options_.map, map.edits);
  settle(map.movable, map.edits);
  if (extras.scans) map.scans = kept.drives.scans();
  if (extras.grids) map.grids = grids_of(ledger, glass, map);
  return map;
}

Site::Difference Site::difference(Stamp from, std::optional<Stamp> to,
                                  const ProgressCallback& progress) const {
  VisitLedger before;
  VisitLedger ledger;
  const Kept kept = load({}, progress);
  Difference difference{
      .now = draw(kept, progress, [&](const SiteSession& session, const DriveVisit& visit) {
        if (!(from < session.begins)) before.add(visit.map);
        if (!to || !(*to < session.begins)) ledger.add(visit.map);
      })};
  if (before.visits() == 0)
    throw DataError({file_.path()},
                    fmt::format("of {} no session is kept any more, or none yet", utc_text(from)));
  difference.now.result.map = ledger.map();
  difference.now.movable = ledger.movable();
  difference.before = before.map();
  std::vector<SiteCorrection>& edits = difference.now.edits;
  edits = corrections_on(kept);
  correct(difference.before, options_.map, edits);
  correct(difference.now.result.map, options_.map, edits);
  settle(difference.now.movable, edits);
  difference.changes = changes_between(difference.before, difference.now.result.map);
  return difference;
}

std::string utc_text(Stamp stamp) {
  const std::int64_t seconds = stamp.nanoseconds / 1'000'000'000;
  const std::chrono::sys_seconds time{std::chrono::seconds{seconds}};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss clock{time - day};
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count());
}

SitePruning prune_site(const std::string& path, std::vector<std::int64_t> sessions, bool pending,
                       Threads threads, const SiteWatch& watch) {
  SitePruning pruning;
  {
    Site site(path, SiteAccess::kWrite, threads);
    pruning.bytes_before = site.file().bytes();
    for (const SiteSession& session : site.sessions()) {
      const bool is_named = std::ranges::find(sessions, session.id) != sessions.end();
      if (pending && !is_named && session.status == SessionStatus::kPending)
        sessions.push_back(session.id);
    }
    if (!sessions.empty()) site.remove(sessions, watch);
  }
  pruning.removed = sessions.size();
  SiteFile file(path, SiteAccess::kWrite);
  file.compact();
  pruning.bytes = file.bytes();
  return pruning;
}

std::optional<Stamp> parse_utc(const std::string& text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  int hour = 0;
  int minute = 0;
  int second = 0;
  int read = 0;
  std::string rest = text;
  if (rest.ends_with('Z')) rest.pop_back();
  const auto is_whole = [&](int fields, int wanted) {
    return fields == wanted && static_cast<std::size_t>(read) == rest.size();
  };
  const bool fits =
      is_whole(std::sscanf(rest.c_str(), "%4d-%2u-%2u%n", &year, &month, &day, &read), 3) ||
      is_whole(std::sscanf(rest.c_str(), "%4d-%2u-%2uT%2d:%2d%n", &year, &month, &day, &hour,
                           &minute, &read),
               5) ||
      is_whole(std::sscanf(rest.c_str(), "%4d-%2u-%2uT%2d:%2d:%2d%n", &year, &month, &day, &hour,
                           &minute, &second, &read),
               6);
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{month},
                                         std::chrono::day{day}};
  if (!fits || !date.ok() || hour > 23 || minute > 59 || second > 59 || hour < 0 || minute < 0 ||
      second < 0)
    return {};
  const auto time = std::chrono::sys_days(date) + std::chrono::hours(hour) +
                    std::chrono::minutes(minute) + std::chrono::seconds(second);
  return Stamp{
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count()};
}

std::optional<Stamp> parse_utc_end(const std::string& text) {
  const std::optional<Stamp> begins = parse_utc(text);
  constexpr std::size_t kDayAlone = 10;
  if (!begins || text.size() != kDayAlone) return begins;
  return *begins + Duration::from_seconds(86'400.0 - 1e-9);
}

}  // namespace loopstone
