#include "loopstone/slam/back_end.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/graph/solver.hpp"
#include "slam/pairwise_consistency.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

/// A closure whose residual is less likely than this (chi-square, 3 degrees of freedom, 1e-5) does
/// not stand.
constexpr double kRevokeChi2 = 26.0;
/// A closure that would bend the map and that is consistent with no other one needs at least this.
constexpr double kLoneOverlap = 0.5;
constexpr double kLoneAgreement = 0.9;
/// As long as closures say together no more than this that the map does not, solving it can wait.
constexpr double kNewsChi2 = 6.0;
/// Rounds of looking everywhere with ever better poses.
constexpr int kFinalRounds = 2;

}  // namespace

BackEnd::BackEnd(const MapOptions& options, Threads threads)
    : loop_closure_(options.loop_closure),
      loops_(options.loop, options.submap, options.match, threads),
      chain_(options.loop.drift_per_m) {}

void BackEnd::add_key(const KeyScan& key) {
  chain_.add(key);
  const std::size_t newest = chain_.stretch_count() - 1;
  if (newest < outline_.poses.size()) return;
  if (newest == 0) {
    outline_.poses.push_back(key.local_T_robot);
    return;
  }
  const PoseWithCovariance2& motion = chain_.across(newest - 1);
  const int from = static_cast<int>(newest) - 1;
  outline_.edges.push_back(edge_between(from, from + 1, motion, EdgeKind::kOdometry));
  outline_.poses.push_back(outline_.poses.back() * motion.pose);
}

void BackEnd::add_submap(FinishedSubmap submap) {
  const Stopwatch watch;
  loops_.add(std::move(submap), chain_.travelled_m()[loops_.submap_count()]);
  std::vector<LoopClosure> found;
  if (loop_closure_) found = loops_.close_newest(outline_.poses);
  loop_closing_s_ += watch.seconds();
  take(std::move(found));
  thin_covered();
}

/// A stretch lies in the submap that it starts and in the one before.
void BackEnd::thin_covered() {
  for (const SubmapId submap : loops_.drop_covered()) {
    events_.emplace_back(SubmapDropped{submap});
    for (const std::size_t stretch : {submap.index, submap.index + 1}) {
      if (stretch == 0 || stretch >= loops_.submap_count()) continue;
      if (!loops_.is_dropped({stretch - 1}) || !loops_.is_dropped({stretch})) continue;
      chain_.thin(stretch);
      thinned_.push_back(stretch);
    }
  }
}

std::vector<std::size_t> BackEnd::take_thinned() { return std::exchange(thinned_, {}); }

void BackEnd::finish(const std::function<bool()>& goes_on) {
  if (unsolved_chi2() > 0.0) solve_outline();
  for (int round = 0; loop_closure_ && round < kFinalRounds && (!goes_on || goes_on()); ++round) {
    const Stopwatch watch;
    auto found = loops_.close_all(outline_.poses, goes_on);
    loop_closing_s_ += watch.seconds();
    take(std::move(found));
  }
  accept_lone();
  loops_.drop_all();

  graph_ = chain_.expand(outline_.poses);
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
                        closure.overlap >= kLoneOverlap && closure.agreement >= kLoneAgreement;
    closure.state = strong ? ClosureState::kStanding : ClosureState::kRejected;
    closure.reason = strong ? ClosureReason::kNone : ClosureReason::kNoSecond;
    news = news || strong;
    events_.emplace_back(ClosureChanged{closure});
  }
  if (news) solve_outline();
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
  const auto settle = [this] {
    return accept_consistent(closures_, {outline_.poses, chain_.travelled_m()});
  };
  bool news = false;
  for (auto accepted = settle(); !accepted.empty(); accepted = settle()) {
    for (const std::size_t i : accepted) events_.emplace_back(ClosureChanged{closures_[i]});
    news = true;
    if (unsolved_chi2() < kNewsChi2) break;
    solve_outline();
  }
  if (news) loops_.set_closures(closures_);
}

/// How much the closures accepted since the last solution disagree with it.
double BackEnd::unsolved_chi2() const {
  double sum = 0.0;
  for (const auto& closure : closures_) {
    if (!closure.stands() || closure.chi2) continue;
    sum += chi2_at(closure, outline_.poses);
  }
  return sum;
}

/// Of the stretches' first poses, and tells how far they moved.
void BackEnd::solve_outline() {
  const std::vector<Pose2> before = outline_.poses;
  solve(outline_);
  GraphSolved solved{.submaps = before.size()};
  solved.closures =
      static_cast<std::size_t>(std::ranges::count_if(closures_, &LoopClosure::stands));
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Pose2& now = outline_.poses[i];
    const double shift_m = (now.translation() - before[i].translation()).norm();
    solved.mean_shift_m += shift_m / static_cast<double>(before.size());
    solved.largest_shift_m = std::max(solved.largest_shift_m, shift_m);
    solved.largest_turn_rad =
        std::max(solved.largest_turn_rad, std::abs(wrap_angle(now.yaw - before[i].yaw)));
  }
  events_.emplace_back(solved);
}

SubmapState BackEnd::state_of(SubmapId submap) const {
  if (submap.index >= loops_.submap_count()) return SubmapState::kOpen;
  return loops_.is_dropped(submap) ? SubmapState::kDropped : SubmapState::kFrozen;
}

/// \param graph  of the closures' nodes; without them
void BackEnd::solve(PoseGraph& graph) {
  const Stopwatch watch;
  while (true) {
    PoseGraph whole = graph;
    for (const auto& closure : closures_) {
      if (closure.stands()) whole.edges.push_back(edge_of(closure));
    }
    graph.poses = optimize(whole, closure_solver()).poses;
    // The worst closure that can't be reconciled goes; then the rest is solved again.
    LoopClosure* worst = nullptr;
    for (auto& closure : closures_) {
      if (!closure.stands()) continue;
      closure.chi2 = chi2_at(closure, graph.poses);
      if (*closure.chi2 > kRevokeChi2 && (worst == nullptr || closure.chi2 > worst->chi2))
        worst = &closure;
    }
    if (worst == nullptr) break;
    worst->state = ClosureState::kRevoked;
    worst->reason = ClosureReason::kContradictsGraph;
    events_.emplace_back(ClosureChanged{*worst});
  }
  optimisation_s_ += watch.seconds();
}

}  // namespace loopstone
