#include "loopstone/slam/joined_drives.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/base/union_find.hpp"
#include "slam/drive_seats.hpp"
#include "slam/drive_ties.hpp"
#include "slam/finish_steps.hpp"

namespace loopstone {

namespace {

/// Of the drives of a back end: which of them a submap is of, and its place there.
class Seats {
 public:
  explicit Seats(std::span<const DriveSeat> seats) : seats_(seats) {}
  [[nodiscard]] std::size_t drive_of(SubmapId submap) const {
    const auto after = std::ranges::upper_bound(seats_, submap.index, {}, &DriveSeat::submap);
    return static_cast<std::size_t>(after - seats_.begin()) - 1;
  }
  [[nodiscard]] SubmapId within(SubmapId submap) const {
    return {submap.index - seats_[drive_of(submap)].submap};
  }
  [[nodiscard]] SubmapPair within(const SubmapPair& pair) const {
    return {within(pair.newer), within(pair.older)};
  }

 private:
  std::span<const DriveSeat> seats_;
};

/// The pair of drives that a pair of submaps is of, made where there is none; in the order of the
/// newer drive, then of the older.
class PairTable {
 public:
  DrivePair& of(std::size_t older, std::size_t newer) {
    DrivePair& pair = pairs_[{newer, older}];
    pair.older = older;
    pair.newer = newer;
    return pair;
  }
  [[nodiscard]] std::vector<DrivePair> take() {
    std::vector<DrivePair> all;
    for (auto& [key, pair] : pairs_) all.push_back(std::move(pair));
    return all;
  }

 private:
  std::map<std::pair<std::size_t, std::size_t>, DrivePair> pairs_{};
};

/// What a drive found of itself.
DrivePair own_pair(const DriveRecord& drive, std::size_t place) {
  const BackEnd::State& own = drive.back_end;
  return {.older = place,
          .newer = place,
          .closures = own.closures,
          .tried = own.loops.tried,
          .tried_by_appearance = own.loops.tried_by_appearance,
          .seen = own.loops.seen};
}

/// As a back end has them, the submaps of all drives counted one after the other.
void put_pair(const DrivePair& pair, std::span<const DriveSeat> seats, BackEnd::State& all) {
  const std::size_t older = seats[pair.older].submap;
  const std::size_t newer = seats[pair.newer].submap;
  const auto counted = [&](const SubmapPair& within) {
    return SubmapPair{{within.newer.index + newer}, {within.older.index + older}};
  };
  for (LoopClosure closure : pair.closures) {
    closure.from_submap.index += older;
    closure.to_submap.index += newer;
    closure.from = {static_cast<int>(closure.from_submap.index)};
    closure.to = {static_cast<int>(closure.to_submap.index)};
    all.closures.push_back(closure);
  }
  for (const auto& [within, pose] : pair.tried) all.loops.tried.emplace(counted(within), pose);
  for (const SubmapPair& within : pair.tried_by_appearance)
    all.loops.tried_by_appearance.insert(counted(within));
  for (const auto& [within, seen] : pair.seen) all.loops.seen.emplace(counted(within), seen);
}

void put_standing(BackEnd::State& all) {
  std::vector<SubmapRecord>& submaps = all.chain.submaps;
  for (const LoopClosure& closure : all.closures) {
    if (!closure.stands()) continue;
    all.loops.standing.insert({closure.to_submap, closure.from_submap});
    submaps[closure.from_submap.index].closed_with.push_back(closure.to_submap);
    submaps[closure.to_submap.index].closed_with.push_back(closure.from_submap);
  }
}

/// What closures say from now on is asked of covering as if it were new.
void forget_covered(std::vector<DrivePlacement>& placements) {
  for (DrivePlacement& placement : placements)
    placement.covered.assign(placement.covered.size(), false);
}

void ask_covering(BackEnd::State& all) {
  for (const LoopClosure& closure : all.closures)
    if (closure.stands()) all.loops.newly_closed.insert(closure.to_submap);
}

/// Of each drive, the first of those that closures tie it to.
std::vector<std::size_t> tied_by(std::span<const DrivePair> pairs, std::size_t drives) {
  std::vector<std::size_t> parents(drives);
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (const DrivePair& pair : pairs)
    if (pair.standing() > 0) join(parents, pair.older, pair.newer);
  for (std::size_t i = 0; i < drives; ++i) parents[i] = root_of(parents, i);
  return parents;
}

/// Counts the drives of others, of which some are gone.
/// \param kept  of each drive, whether it stays
void renumber(std::vector<DrivePair>& pairs, const std::vector<bool>& kept) {
  std::vector<std::size_t> places(kept.size());
  std::exclusive_scan(kept.begin(), kept.end(), places.begin(), std::size_t{0});
  std::erase_if(pairs,
                [&](const DrivePair& pair) { return !kept[pair.older] || !kept[pair.newer]; });
  for (DrivePair& pair : pairs) {
    pair.older = places[pair.older];
    pair.newer = places[pair.newer];
  }
}

/// The map is that of the most drives which closures tie; of as many, that with the first of them.
/// \param sets  of each drive: the first one of its set
void mark_largest(std::span<const std::size_t> sets, std::vector<DrivePlacement>& placements) {
  std::size_t largest = 0;
  std::ptrdiff_t most = 0;
  for (const std::size_t set : sets) {
    const auto size = std::ranges::count(sets, set);
    if (size > most) largest = set;
    most = std::max(most, size);
  }
  for (std::size_t i = 0; i < sets.size(); ++i) placements[i].is_joined = sets[i] == largest;
}

void add_up(const MapStatistics& drive, MapStatistics& all) {
  all.scans_dropped += drive.scans_dropped;
  all.key_scans += drive.key_scans;
  all.searches += drive.searches;
  all.degenerate_travel_m += drive.degenerate_travel_m;
  all.front_end_s += drive.front_end_s;
}

}  // namespace

DriveRecord record_of(MapperState state, const MapOptions& options) {
  if (!state.so_far.drives.empty()) throw UsageError("record_of: a mapper of one drive is needed");
  BackEnd back_end(options, {1});
  back_end.restore(std::move(state.back_end));
  for (WaitingScan& step : state.waiting) {
    if (step.key) back_end.add_key(*step.key);
    back_end.add_scan(std::move(step.scan));
  }
  DriveRecord record{.track = std::move(state.so_far.track),
                     .breaks = std::move(state.so_far.breaks),
                     .statistics = state.so_far.statistics,
                     .gyro_scans = state.so_far.gyro_scans,
                     .back_end = back_end.state()};
  // How long it took is no part of what was found.
  record.statistics.front_end_s = 0.0;
  record.back_end.loop_closing_s = record.back_end.optimisation_s = 0.0;
  // What the last scans saw is drawn, but was too little for a submap.
  for (SubmapRecord& submap : record.back_end.chain.submaps)
    if (submap.state == SubmapState::kOpen) submap.drop();
  return record;
}

int DrivePair::standing() const {
  return static_cast<int>(std::ranges::count_if(closures, &LoopClosure::stands));
}

JoinedDrives::JoinedDrives(const MapOptions& options, Threads threads)
    : options_(options), threads_(threads) {
  require_valid(options_);
}

void JoinedDrives::restore(std::vector<std::shared_ptr<const DriveRecord>> drives,
                           std::vector<DrivePair> pairs, std::vector<DrivePlacement> placements) {
  const auto submaps = [&](std::size_t drive) {
    return drives[drive]->back_end.chain.submaps.size();
  };
  bool fits = placements.size() == drives.size();
  for (std::size_t i = 0; fits && i < drives.size(); ++i) {
    fits = placements[i].map_T_submaps.size() == submaps(i) &&
           placements[i].covered.size() == submaps(i) &&
           std::ranges::all_of(placements[i].map_T_submaps,
                               [](const Pose2& pose) { return is_sound(pose); });
  }
  const auto exists = [&](const DrivePair& pair, SubmapId older, SubmapId newer) {
    return older.index < submaps(pair.older) && newer.index < submaps(pair.newer) &&
           (pair.older != pair.newer || older < newer);
  };
  for (const DrivePair& pair : pairs) {
    fits = fits && pair.older <= pair.newer && pair.newer < drives.size();
    const auto is_there = [&](const SubmapPair& of) { return exists(pair, of.older, of.newer); };
    fits = fits &&
           std::ranges::all_of(pair.closures,
                               [&](const LoopClosure& c) {
                                 return exists(pair, c.from_submap, c.to_submap) &&
                                        is_sound(c.from_T_to);
                               }) &&
           std::ranges::all_of(pair.tried, [&](const auto& one) { return is_there(one.first); }) &&
           std::ranges::all_of(pair.tried_by_appearance, is_there) &&
           std::ranges::all_of(pair.seen, [&](const auto& one) { return is_there(one.first); });
  }
  require_sound(fits, "drives that contradict each other");
  drives_ = std::move(drives);
  pairs_ = std::move(pairs);
  placements_ = std::move(placements);
}

BackEnd::State JoinedDrives::assemble() const {
  const std::vector<DriveSeat> seats = seats_of(drives_);
  KeyChain chain(options_.loop.drift_per_m);
  for (std::size_t i = 0; i < drives_.size(); ++i)
    chain.append(seated(drives_[i]->back_end.chain, seats[i]));
  BackEnd::State all{.chain = chain.state()};
  for (const DrivePair& pair : pairs_) put_pair(pair, seats, all);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    // A drive that was not placed yet lies beside the one before.
    const DrivePlacement& placement = placements_[i];
    for (std::size_t k = 0; k < placement.covered.size(); ++k) {
      SubmapRecord& submap = all.chain.submaps[seats[i].submap + k];
      submap.map_T_submap = placement.map_T_submaps[k];
      if (placement.covered[k]) submap.drop();
    }
  }
  put_standing(all);
  return all;
}

void JoinedDrives::take_apart(const BackEnd::State& state) {
  const std::vector<DriveSeat> seat_list = seats_of(drives_);
  const Seats seats(seat_list);
  PairTable table;
  const auto pair_of = [&](SubmapId older, SubmapId newer) -> DrivePair& {
    return table.of(seats.drive_of(older), seats.drive_of(newer));
  };
  for (LoopClosure closure : state.closures) {
    DrivePair& pair = pair_of(closure.from_submap, closure.to_submap);
    closure.from_submap = seats.within(closure.from_submap);
    closure.to_submap = seats.within(closure.to_submap);
    pair.closures.push_back(closure);
  }
  for (const auto& [key, pose] : state.loops.tried)
    pair_of(key.older, key.newer).tried.emplace(seats.within(key), pose);
  for (const SubmapPair& key : state.loops.tried_by_appearance)
    pair_of(key.older, key.newer).tried_by_appearance.insert(seats.within(key));
  for (const auto& [key, seen] : state.loops.seen)
    pair_of(key.older, key.newer).seen.emplace(seats.within(key), seen);
  pairs_ = table.take();

  const std::vector<SubmapRecord>& submaps = state.chain.submaps;
  placements_.clear();
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const std::vector<SubmapRecord>& own = drives_[i]->back_end.chain.submaps;
    DrivePlacement placement;
    for (std::size_t k = 0; k < own.size(); ++k) {
      const SubmapRecord& submap = submaps[seat_list[i].submap + k];
      placement.map_T_submaps.push_back(submap.map_T_submap);
      placement.covered.push_back(submap.state == SubmapState::kDropped &&
                                  own[k].state != SubmapState::kDropped);
    }
    placements_.push_back(std::move(placement));
  }
  mark_largest(tied_by(pairs_, drives_.size()), placements_);
}

void JoinedDrives::add(std::shared_ptr<const DriveRecord> drive,
                       const std::function<bool()>& goes_on) {
  const std::size_t place = drives_.size();
  const std::vector<std::size_t> before = tied_by(pairs_, place + 1);
  pairs_.push_back(own_pair(*drive, place));
  placements_.emplace_back();
  drives_.push_back(std::move(drive));
  for (int round = 0; round < kDriveTies.rounds; ++round) {
    BackEnd back_end(options_, threads_);
    back_end.restore(assemble());
    if (place > 0) back_end.search_drive({seats_of(drives_).back().submap}, goes_on);
    take_apart(back_end.state());
    if (!untie(before)) return;
  }
}

/// Of drives that were not tied before, those that the map lays on each other must show one place;
/// else what ties them is taken back. Returns whether something was.
bool JoinedDrives::untie(const std::vector<std::size_t>& before) {
  const std::vector<std::size_t> now = tied_by(pairs_, drives_.size());
  std::vector<std::size_t> parts = before;
  for (std::size_t a = 0; a < before.size(); ++a) {
    for (std::size_t b = a + 1; b < before.size(); ++b) {
      if (before[a] != a || before[b] != b || now[a] != now[b]) continue;
      if (show_one_place(before, a, b)) join(parts, a, b);
    }
  }
  bool news = false;
  for (DrivePair& pair : pairs_) {
    if (root_of(parts, pair.older) == root_of(parts, pair.newer)) continue;
    for (LoopClosure& closure : pair.closures) {
      if (!closure.stands()) continue;
      closure.state = ClosureState::kRevoked;
      closure.reason = ClosureReason::kSurroundings;
      news = true;
    }
  }
  if (!news) return false;
  forget_covered(placements_);
  BackEnd::State all = assemble();
  ask_covering(all);
  BackEnd back_end(options_, threads_);
  back_end.restore(std::move(all));
  back_end.lay_anew();
  take_apart(back_end.state());
  return true;
}

LaidDrive JoinedDrives::laid(std::size_t drive) const {
  return {drives_[drive]->back_end.chain.submaps, placements_[drive].map_T_submaps};
}

/// Whether two sets of drives do, by those of them that overlap the most.
/// \param sets  of each drive: the first one of its set
bool JoinedDrives::show_one_place(const std::vector<std::size_t>& sets, std::size_t one,
                                  std::size_t other) const {
  struct Overlap {
    std::size_t older;
    std::size_t newer;
    std::vector<SubmapPair> pairs;
  };
  std::vector<Overlap> overlaps;
  for (std::size_t a = 0; a < sets.size(); ++a) {
    for (std::size_t b = a + 1; b < sets.size(); ++b) {
      const bool is_between =
          (sets[a] == one && sets[b] == other) || (sets[a] == other && sets[b] == one);
      if (is_between) overlaps.push_back({a, b, overlapping(laid(a), laid(b))});
    }
  }
  std::ranges::stable_sort(overlaps, std::ranges::greater{},
                           [](const Overlap& of) { return of.pairs.size(); });
  if (overlaps.size() > kDriveTies.drives_max) overlaps.resize(kDriveTies.drives_max);
  std::erase_if(
      overlaps,
      [enough = kDriveTies.least_overlap * static_cast<double>(overlaps.front().pairs.size())](
          const Overlap& of) { return static_cast<double>(of.pairs.size()) < enough; });
  const auto scatter = [&](std::size_t drive) {
    return scatter_of(laid(drive), options_.submap, options_.match, threads_);
  };
  return std::ranges::any_of(overlaps, [&](const Overlap& of) {
    const SurfaceFit fit =
        fit_of(laid(of.older), laid(of.newer), of.pairs, options_.submap, options_.match, threads_);
    // Mostly it is not needed to know.
    return shows_one_place(fit, 0.0) ||
           shows_one_place(fit, std::max(scatter(of.older), scatter(of.newer)));
  });
}

bool JoinedDrives::shows_something_alone(std::size_t drive) const {
  const std::vector<SubmapRecord>& submaps = drives_[drive]->back_end.chain.submaps;
  for (std::size_t i = 0; i < submaps.size(); ++i)
    if (submaps[i].state == SubmapState::kFrozen && !placements_[drive].covered[i]) return true;
  return false;
}

void JoinedDrives::remove(std::size_t drive) {
  const bool tied_others = std::ranges::any_of(pairs_, [&](const DrivePair& pair) {
    return pair.older != pair.newer && (pair.older == drive || pair.newer == drive) &&
           pair.standing() > 0;
  });
  const bool showed_alone = tied_others && shows_something_alone(drive);
  const auto place = static_cast<std::ptrdiff_t>(drive);
  std::vector<bool> kept(drives_.size(), true);
  kept[drive] = false;
  renumber(pairs_, kept);
  drives_.erase(drives_.begin() + place);
  placements_.erase(placements_.begin() + place);
  if (drives_.empty()) return;
  // Whom it covered shows what nobody else does, perhaps.
  if (showed_alone) forget_covered(placements_);
  BackEnd::State all = assemble();
  ask_covering(all);
  BackEnd back_end(options_, threads_);
  back_end.restore(std::move(all));
  back_end.drop_covered();
  // Those that it tied are compared with one another, until they show each other.
  if (showed_alone) back_end.search_drive({0});
  take_apart(back_end.state());
}

/// Drive by drive, as many as were joined; as long as it goes on.
void JoinedDrives::draw_visits(std::span<const PosedScan> scans, std::span<const DriveSeat> seats,
                               double footprint_m, const TakeVisit& take_visit,
                               const ProgressCallback& goes_on) const {
  std::size_t first = 0;
  for (std::size_t drive = 0; drive < seats.size(); ++drive) {
    if (!goes_on({"drawing", static_cast<std::int64_t>(drive), std::ssize(seats)})) return;
    const Stamp ends = drives_[drive]->track.back().stamp + seats[drive].clock_shift;
    std::size_t end = first;
    while (end < scans.size() && !(ends < scans[end].scan->stamp)) ++end;
    const std::span<const PosedScan> own = scans.subspan(first, end - first);
    take_visit({.drive = drive,
                .scans = own,
                .map = build_occupancy_map(own, footprint_m, options_.map, threads_)});
    first = end;
  }
}

JoinedDrives JoinedDrives::joined_alone() const {
  JoinedDrives joined(options_, threads_);
  std::vector<bool> kept;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    kept.push_back(placements_[i].is_joined);
    if (!kept.back()) continue;
    joined.drives_.push_back(drives_[i]);
    joined.placements_.push_back(placements_[i]);
  }
  joined.pairs_ = pairs_;
  renumber(joined.pairs_, kept);
  return joined;
}

MappedScans JoinedDrives::scans() const {
  MappedScans scans;
  for (const SubmapRecord& submap : joined_alone().assemble().chain.submaps) {
    if (const auto shared = submap.scans.share())
      scans.insert(scans.end(), shared->begin(), shared->end());
  }
  return scans;
}

MapResult JoinedDrives::finish(const RobotModel& robot, const TakeVisit& take_visit,
                               const ProgressCallback& progress) const {
  return joined_alone().finish_all(robot, take_visit, progress);
}

MapResult JoinedDrives::finish_all(const RobotModel& robot, const TakeVisit& take_visit,
                                   const ProgressCallback& progress) const {
  BackEnd back_end(options_, threads_);
  back_end.restore(assemble());
  back_end.finish([] { return false; });  // everything was looked for

  // Of several drives nothing is told of one robot's mount and wheels.
  SettledMap map{.robot = robot, .options = options_};
  map.options.calibration = false;
  MapResult& counted = map.counted;
  const std::vector<DriveSeat> seats = seats_of(drives_);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const DriveRecord& drive = *drives_[i];
    for (const TrackedPose& pose : drive.track) map.track.push_back(seated(pose, seats[i]));
    if (i > 0) {
      counted.breaks.push_back(seats[i].before);
      counted.drives.push_back({.first_scan = seats[i].scan,
                                .clock_shift_ns = seats[i].clock_shift.nanoseconds,
                                .local_T_drive = seats[i].local_T_drive});
    }
    for (const PathBreak& gap : drive.breaks) counted.breaks.push_back(seated(gap, seats[i]));
    add_up(drive.statistics, counted.statistics);
    map.has_gyro = map.has_gyro || drive.gyro_scans > 0;
  }
  counted.statistics.scans = static_cast<std::int64_t>(map.track.size());
  counted.statistics.path_length_m = back_end.path_length_m();
  counted.statistics.submaps = static_cast<std::int64_t>(back_end.submap_count());
  map.chain = back_end.chain();

  bool complete = true;
  const auto goes_on = [&](const Progress& news) {
    return complete = complete && (!progress || progress(news));
  };
  FinishCalls calls;
  calls.goes_on_to = [&](int stage) { return goes_on({"finishing", stage, kFinishStages}); };
  if (take_visit) {
    calls.draw = [&](std::span<const PosedScan> scans) {
      draw_visits(scans, seats, robot.footprint_radius_m, take_visit, goes_on);
      return OccupancyMap{};
    };
  }
  return finish_settled(map, {back_end.graph(), back_end.closures()}, calls, threads_);
}

}  // namespace loopstone
