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
  for (const std::size_t submap : loops_.drop_covered()) {
    for (const std::size_t stretch : {submap, submap + 1}) {
      if (stretch == 0 || stretch >= loops_.submap_count()) continue;
      if (!loops_.is_dropped(stretch - 1) || !loops_.is_dropped(stretch)) continue;
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
    closure.from = nodes[closure.from_submap];
    closure.to = nodes[closure.to_submap];
  }
  if (std::any_of(closures_.begin(), closures_.end(), [](const auto& c) { return c.accepted; }))
    solve(graph_);
  for (const auto& closure : closures_) {
    if (closure.accepted) graph_.edges.push_back(loops_.edge_of(closure));
  }
}

/// The recording is over, and no second closure will come. Strong evidence is believed without one.
void BackEnd::accept_lone() {
  bool news = false;
  for (auto& closure : closures_) {
    if (closure.accepted || closure.reason != kWaitsForWitness) continue;
    closure.accepted = !loops_.tried_for_looks(closure) && closure.second_score == 0.0 &&
                       closure.overlap >= kLoneOverlap && closure.agreement >= kLoneAgreement;
    closure.reason = closure.accepted ? "" : "no second closure asks for the same";
    news = news || closure.accepted;
  }
  if (news) solve(outline_);
}

void BackEnd::take(std::vector<LoopClosure> found) {
  for (auto& closure : found) {
    // What was tried before and failed is replaced by the newer attempt.
    std::erase_if(closures_, [&](const LoopClosure& old) {
      return !old.accepted && old.from_submap == closure.from_submap &&
             old.to_submap == closure.to_submap;
    });
    if (closure.accepted) {
      closure.accepted = false;
      closure.reason = kWaitsForWitness;
    }
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
    if (!closure.accepted || closure.chi2 > 0.0) continue;
    sum += edge_chi2(loops_.edge_of(closure), outline_.poses[closure.from_submap],
                     outline_.poses[closure.to_submap]);
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
      if (closure.accepted) whole.edges.push_back(loops_.edge_of(closure));
    }
    graph.poses = optimize(whole, solver).poses;
    // The worst closure that can't be reconciled goes; then the rest is solved again.
    LoopClosure* worst = nullptr;
    for (auto& closure : closures_) {
      if (!closure.accepted) continue;
      const auto edge = loops_.edge_of(closure);
      const Eigen::Vector3d error =
          edge_error(edge, graph.poses[static_cast<std::size_t>(edge.from.index)],
                     graph.poses[static_cast<std::size_t>(edge.to.index)]);
      closure.chi2 = error.dot(edge.information * error);
      if (closure.chi2 > kRevokeChi2 && (worst == nullptr || closure.chi2 > worst->chi2))
        worst = &closure;
    }
    if (worst == nullptr) break;
    worst->accepted = false;
    worst->reason = "revoked: contradicts the rest of the graph";
  }
  optimisation_s_ += watch.seconds();
}

}  // namespace loopstone
