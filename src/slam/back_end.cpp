#include "loopstone/slam/back_end.hpp"

#include <algorithm>
#include <utility>

#include "loopstone/graph/solver.hpp"
#include "slam/closure_witness.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

/// A closure whose residual is less likely than this (chi-square, 3 degrees of freedom, 1e-5) does not stand.
constexpr double kRevokeChi2 = 26.0;
/// A closure that would bend the map and that no other one bears witness for needs at least this.
constexpr double kLoneOverlap = 0.5;
constexpr double kLoneAgreement = 0.9;
/// As long as closures say together no more than this that the map does not, solving it can wait.
constexpr double kNewsChi2 = 6.0;
/// Rounds of looking everywhere with ever better poses.
constexpr int kFinalRounds = 2;

double chi2_at(const LoopClosure& closure, std::span<const Pose2> poses) {
  const auto pose = [&](NodeId node) { return poses[static_cast<std::size_t>(node.index)]; };
  return edge_chi2(edge_of(closure), pose(closure.from), pose(closure.to));
}

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
  if (unsolved_chi2() > 0.0) solve(outline_);
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
  }
  if (news) solve(outline_);
}

void BackEnd::take(std::vector<LoopClosure> found) {
  for (auto& closure : found) {
    // What was tried before and failed is replaced by the newer attempt.
    std::erase_if(closures_, [&](const LoopClosure& old) {
      return !old.stands() && old.from_submap == closure.from_submap &&
             old.to_submap == closure.to_submap;
    });
    closures_.push_back(std::move(closure));
  }
  // Each solution brings the map nearer to the truth, so that more of those that wait may agree with it.
  bool news = false;
  while (accept_witnessed(closures_, {outline_.poses, chain_.travelled_m()})) {
    news = true;
    if (unsolved_chi2() < kNewsChi2) break;
    solve(outline_);
  }
  if (news) loops_.set_closures(closures_);
}

/// How much the closures accepted since the last solution disagree with it.
double BackEnd::unsolved_chi2() const {
  double sum = 0.0;
  for (const auto& closure : closures_) {
    if (!closure.stands() || closure.chi2) continue;
    sum += edge_chi2(edge_of(closure), outline_.poses[closure.from_submap.index],
                     outline_.poses[closure.to_submap.index]);
  }
  return sum;
}

/// \param graph  of the closures' nodes; without them
void BackEnd::solve(PoseGraph& graph) {
  const Stopwatch watch;
  const SolverOptions solver{.robust_kernel = "huber", .robust_width = kClosureHuberWidth};
  while (true) {
    PoseGraph whole = graph;
    for (const auto& closure : closures_) {
      if (closure.stands()) whole.edges.push_back(edge_of(closure));
    }
    graph.poses = optimize(whole, solver).poses;
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
  }
  optimisation_s_ += watch.seconds();
}

}  // namespace loopstone
