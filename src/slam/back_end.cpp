#include "loopstone/slam/back_end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "slam/closure_solution.hpp"
#include "slam/drives.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_surroundings.hpp"
#include "slam/pairwise_consistency.hpp"
#include "slam/rival_places.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// From where to where along x of the map what was seen on a submap's stretch reaches.
std::pair<double, double> width_of(const SubmapRecord& submap) {
  double low = kInfinite;
  double high = -kInfinite;
  const Pose2 local_T_first = submap.keys.front().local_T_robot;
  submap.scans.for_each([&](const MappedScan& mapped) {
    double reach_m = 0.0;
    for (const float range : mapped.scan.ranges_m) {
      if (std::isfinite(range)) reach_m = std::max(reach_m, static_cast<double>(range));
    }
    const Pose2 map_T_robot =
        submap.map_T_submap * (local_T_first.inverse() * mapped.local_T_robot);
    reach_m += mapped.robot_T_lidar.translation().norm();
    low = std::min(low, map_T_robot.x - reach_m);
    high = std::max(high, map_T_robot.x + reach_m);
  });
  return {low, high};
}

/// Its ends are of two pieces of the path.
bool across_break(const LoopClosure& closure, std::span<const SubmapRecord> submaps) {
  return submaps[closure.from_submap.index].piece != submaps[closure.to_submap.index].piece;
}

void reject(LoopClosure& closure, ClosureReason reason) {
  closure.state = ClosureState::kRejected;
  closure.reason = reason;
}

}  // namespace

BackEnd::BackEnd(const MapOptions& options, Threads threads)
    : loop_closure_(options.loop_closure),
      loop_options_(options.loop),
      submap_options_(options.submap),
      match_options_(options.match),
      threads_(threads),
      loops_(options.loop, options.submap, options.match, threads),
      chain_(options.loop.drift_per_m) {}

void BackEnd::add_key(const KeyScan& key) { chain_.add(key); }

void BackEnd::add_scan(std::shared_ptr<const MappedScan> scan) {
  chain_.submaps().back().scans.add(std::move(scan));
}

std::size_t BackEnd::submap_count() const {
  const auto submaps = chain_.submaps();
  const auto open = std::ranges::find(submaps, SubmapState::kOpen, &SubmapRecord::state);
  return static_cast<std::size_t>(open - submaps.begin());
}

std::span<SubmapRecord> BackEnd::full_submaps() {
  return std::span(chain_.submaps()).first(submap_count());
}

void BackEnd::add_submap(FinishedSubmap submap) {
  const Stopwatch watch;
  chain_.submaps()[submap_count()].freeze(std::move(submap));
  std::vector<LoopClosure> found;
  if (loop_closure_) found = loops_.close_newest(full_submaps());
  loop_closing_s_ += watch.seconds();
  take(std::move(found));
  thin_covered();
}

void BackEnd::search_drive(SubmapId first, const std::function<bool()>& goes_on) {
  const Stopwatch watch;
  const auto may_go_on = [&] { return !goes_on || goes_on(); };
  for (std::size_t newest = first.index; newest < submap_count() && may_go_on(); ++newest) {
    take(loops_.close({newest}, full_submaps()));
    drop_covered();
  }
  for (int round = 0; round < kBackEnd.final_rounds && may_go_on(); ++round)
    take(loops_.close_all(full_submaps(), goes_on));
  drop_covered();
  if (unsolved_chi2() > 0.0) solve_outline();
  loop_closing_s_ += watch.seconds();
}

void BackEnd::lay_anew() {
  solve_outline();
  drop_covered();
}

/// A stretch lies in the submap that it starts and in the one before.
void BackEnd::thin_covered() {
  const auto full = full_submaps();
  const auto is_dropped = [&](std::size_t i) { return full[i].state == SubmapState::kDropped; };
  for (const SubmapId submap : loops_.drop_covered(full)) {
    events_.emplace_back(SubmapDropped{submap});
    for (const std::size_t stretch : {submap.index, submap.index + 1}) {
      if (stretch == 0 || stretch >= full.size()) continue;
      if (is_dropped(stretch - 1) && is_dropped(stretch)) chain_.thin({stretch});
    }
  }
}

void BackEnd::finish(const std::function<bool()>& goes_on) {
  if (unsolved_chi2() > 0.0) solve_outline();
  for (int round = 0; loop_closure_ && round < kBackEnd.final_rounds && (!goes_on || goes_on());
       ++round) {
    const Stopwatch watch;
    auto found = loops_.close_all(full_submaps(), goes_on);
    loop_closing_s_ += watch.seconds();
    take(std::move(found));
  }
  accept_lone();
  set_apart();
  loops_.drop_all(full_submaps());

  graph_ = chain_.expand();
  const auto nodes = chain_.first_nodes();
  for (auto& closure : closures_) {
    closure.from = nodes[closure.from_submap.index];
    closure.to = nodes[closure.to_submap.index];
  }
  if (std::ranges::any_of(closures_, &LoopClosure::stands)) solve(graph_);
  for (const auto& closure : closures_) {
    if (closure.stands()) graph_.edges.push_back(edge_of(closure));
  }
}

/// The recording is over, and no second closure will come. Strong evidence is believed without one.
void BackEnd::accept_lone() {
  bool news = false;
  for (auto& closure : closures_) {
    if (closure.state != ClosureState::kWaiting) continue;
    const bool strong = !closure.by_appearance && !closure.second_score &&
                        closure.overlap >= kBackEnd.lone_overlap &&
                        closure.agreement >= kBackEnd.lone_agreement;
    std::vector<LoopClosure> asked(strong ? 1 : 0, closure);
    ask_around(asked);
    if (strong) closure = asked.front();
    const bool stands = strong && closure.state == ClosureState::kWaiting;
    if (closure.state == ClosureState::kWaiting) {
      closure.state = stands ? ClosureState::kStanding : ClosureState::kRejected;
      closure.reason = stands                 ? ClosureReason::kNone
                       : closure.second_score ? ClosureReason::kAmbiguousPose
                                              : ClosureReason::kNoSecond;
    }
    news = news || stands;
    events_.emplace_back(ClosureChanged{closure});
  }
  if (news) solve_outline();
}

/// The graph of the submaps with the closures that stand.
PoseGraph BackEnd::outline() const {
  PoseGraph graph = chain_.outline();
  for (const auto& closure : closures_) {
    if (closure.stands()) graph.edges.push_back(edge_of(closure));
  }
  return graph;
}

/// What bends the map is asked about in its surroundings: they must hold it where it pulls. Across
/// a break of the path no other place may do as well, even where it bends nothing: then it would
/// make certain what nobody knew. What fails is rejected.
void BackEnd::ask_around(std::vector<LoopClosure>& asked) const {
  if (asked.empty()) return;
  const auto submaps = chain_.submaps();
  const std::vector<Eigen::Matrix3d> known = known_motions(outline(), asked);
  const Drives drives(submaps);
  const auto no_path_leads = [&](const LoopClosure& closure) {
    return drives.are_adrift(closure.from_submap, closure.to_submap);
  };
  parallel_for(asked.size(), threads_, [&](std::size_t i) {
    LoopClosure& closure = asked[i];
    const auto is_held = [&] {
      return hold(surroundings_of(closure, submaps, submap_options_, match_options_),
                  map_pull_of(closure, submaps), kPairwiseConsistency.harmless_m);
    };
    if (no_path_leads(closure)) {
      // Every other place was asked whether it is like the newer one, but one that the older place
      // repeats may be where nobody was yet.
      if (!is_held()) {
        reject(closure, ClosureReason::kSurroundings);
      } else if (repeats_itself(closure, submaps, loop_options_, submap_options_, match_options_)) {
        reject(closure, ClosureReason::kAmbiguousPlace);
      }
      return;
    }
    const auto leads_there = [&] {
      const double travel_m =
          travel_from(submaps, closure.from_submap, kInfinite)[closure.to_submap.index];
      return known.empty() || is_likely(closure, known[i], travel_m, submaps);
    };
    if (!bends_nothing(closure, submaps) && (!leads_there() || !is_held()))
      reject(closure, ClosureReason::kSurroundings);
  });
  if (known.empty()) return;

  std::vector<AskedClosure> left;
  std::vector<LoopClosure*> of_left;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (asked[i].state == ClosureState::kRejected || no_path_leads(asked[i])) continue;
    left.push_back({asked[i], known[i]});
    of_left.push_back(&asked[i]);
  }
  const std::vector<bool> have = have_rival_places(left, closures_, submaps, loop_options_,
                                                   submap_options_, match_options_, threads_);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (have[i]) reject(*of_left[i], ClosureReason::kAmbiguousPlace);
  }
}

/// Lets those closures stand that are consistent, once their surroundings were asked. Returns their
/// places.
std::vector<std::size_t> BackEnd::settle() {
  const auto submaps = chain_.submaps();
  std::set<std::size_t> passed;
  while (true) {
    std::vector<std::size_t> consistent =
        first_ties(closures_, consistent_ones(closures_, submaps), submaps);
    const Drives drives(submaps);
    const auto needs_asking = [&](const LoopClosure& closure) {
      return drives.are_adrift(closure.from_submap, closure.to_submap) ||
             across_break(closure, submaps) || !bends_nothing(closure, submaps);
    };
    std::vector<std::size_t> places;
    std::vector<LoopClosure> asked;
    for (const std::size_t i : consistent) {
      if (!needs_asking(closures_[i]) || !passed.insert(i).second) continue;
      places.push_back(i);
      asked.push_back(closures_[i]);
    }
    ask_around(asked);
    bool rejected = false;
    for (std::size_t k = 0; k < asked.size(); ++k) {
      if (asked[k].state == ClosureState::kWaiting) continue;
      rejected = true;
      closures_[places[k]] = asked[k];
      events_.emplace_back(ClosureChanged{asked[k]});
    }
    // What was rejected is no witness any more.
    if (rejected) continue;
    for (const std::size_t i : consistent) {
      closures_[i].state = ClosureState::kStanding;
      closures_[i].reason = ClosureReason::kNone;
    }
    return consistent;
  }
}

void BackEnd::take(std::vector<LoopClosure> found) {
  for (auto& closure : found) {
    // What was tried before and failed is replaced by the newer attempt.
    std::erase_if(closures_, [&](const LoopClosure& old) {
      return !old.stands() && old.from_submap == closure.from_submap &&
             old.to_submap == closure.to_submap;
    });
    events_.emplace_back(ClosureChanged{closure});
    closures_.push_back(closure);
  }
  // Each solution brings the map nearer to the truth, so that more of those that wait may agree
  // with it.
  bool news = false;
  for (auto accepted = settle(); !accepted.empty(); accepted = settle()) {
    for (const std::size_t i : accepted) events_.emplace_back(ClosureChanged{closures_[i]});
    lay_drives(accepted);
    news = true;
    if (unsolved_chi2() < kBackEnd.news_chi2) break;
    solve_outline();
  }
  if (news) loops_.set_closures(full_submaps(), closures_);
}

/// A drive that was recognised is laid where the first closure puts it, with all that hangs on it:
/// solving has to turn it by little then.
void BackEnd::lay_drives(std::span<const std::size_t> accepted) {
  auto& submaps = chain_.submaps();
  for (const std::size_t i : accepted) {
    const LoopClosure& closure = closures_[i];
    const Drives drives(submaps);
    if (!drives.are_adrift(closure.from_submap, closure.to_submap)) continue;
    const Pose2 map_move = map_move_of(closure, submaps);
    for (const SubmapId submap : drives.with(closure.to_submap)) {
      Pose2& map_T_submap = submaps[submap.index].map_T_submap;
      map_T_submap = map_move * map_T_submap;
    }
    submaps[closure.from_submap.index].closed_with.push_back(closure.to_submap);
    submaps[closure.to_submap.index].closed_with.push_back(closure.from_submap);
  }
}

/// Drives that nothing ties are put side by side, with nothing of one on the other.
void BackEnd::set_apart() {
  auto& submaps = chain_.submaps();
  const Drives drives(submaps);
  if (!drives.any_adrift()) return;
  double edge_m = -kInfinite;  // of all that has its place
  std::vector<bool> placed(submaps.size());
  for (std::size_t first = 0; first < submaps.size(); ++first) {
    if (placed[first]) continue;
    const std::vector<SubmapId> group = drives.with({first});
    double low_m = kInfinite;
    double high_m = -kInfinite;
    for (const SubmapId id : group) {
      placed[id.index] = true;
      const auto [low, high] = width_of(submaps[id.index]);
      low_m = std::min(low_m, low);
      high_m = std::max(high_m, high);
    }
    const double shift_m = std::isfinite(edge_m) ? edge_m + kBackEnd.apart_m - low_m : 0.0;
    for (const SubmapId id : group) submaps[id.index].map_T_submap.x += shift_m;
    edge_m = high_m + shift_m;
  }
}

/// How much the closures accepted since the last solution disagree with it.
double BackEnd::unsolved_chi2() const {
  const std::vector<Pose2> poses = poses_of(chain_.submaps());
  double sum = 0.0;
  for (const auto& closure : closures_) {
    if (!closure.stands() || closure.chi2) continue;
    sum += chi2_at(closure, poses);
  }
  return sum;
}

/// Of the stretches' first poses, and tells how far they moved.
void BackEnd::solve_outline() {
  PoseGraph outline = chain_.outline();
  const std::vector<Pose2> before = outline.poses;
  solve(outline);
  GraphSolved solved{.submaps = before.size()};
  solved.closures =
      static_cast<std::size_t>(std::ranges::count_if(closures_, &LoopClosure::stands));
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Pose2& now = outline.poses[i];
    chain_.submaps()[i].map_T_submap = now;
    const double shift_m = (now.translation() - before[i].translation()).norm();
    solved.mean_shift_m += shift_m / static_cast<double>(before.size());
    solved.largest_shift_m = std::max(solved.largest_shift_m, shift_m);
    solved.largest_turn_rad =
        std::max(solved.largest_turn_rad, std::abs(wrap_angle(now.yaw - before[i].yaw)));
  }
  events_.emplace_back(solved);
}

BackEnd::State BackEnd::state() const {
  return {chain_.state(), loops_.state(), closures_, loop_closing_s_, optimisation_s_};
}

void BackEnd::restore(State state) {
  chain_.restore(std::move(state.chain));
  loops_.restore(std::move(state.loops));
  closures_ = std::move(state.closures);
  loop_closing_s_ = state.loop_closing_s;
  optimisation_s_ = state.optimisation_s;
}

/// \param graph  of the closures' nodes; without them
void BackEnd::solve(PoseGraph& graph) {
  const Stopwatch watch;
  solve_closures(graph, closures_, {}, [&](const LoopClosure& revoked) {
    events_.emplace_back(ClosureChanged{revoked});
  });
  optimisation_s_ += watch.seconds();
}

}  // namespace loopstone
