#include "loopstone/slam/back_end.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/graph/solver.hpp"
#include "slam/closure_witness.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

/// What matching against a submap leaves uncertain between consecutive key scans, however good the match: its slow drift.
constexpr double kChainRestM = 0.004;
constexpr double kChainShare = 0.006;
constexpr double kChainRestRad = 0.0012;
constexpr double kChainTurnShare = 0.004;
/// A closure whose residual is less likely than this (chi-square, 3 degrees of freedom, 1e-5) does not stand.
constexpr double kRevokeChi2 = 26.0;
/// Closures that disagree by more standard deviations than this pull less than in proportion.
constexpr double kHuberWidth = 1.5;
/// A closure that would bend the map and that no other one bears witness for needs at least this.
constexpr double kLoneOverlap = 0.5;
constexpr double kLoneAgreement = 0.9;
/// Rounds of looking everywhere with ever better poses.
constexpr int kFinalRounds = 2;

RelativePoseEdge chain_edge(int from, const KeyScan& previous, const KeyScan& next) {
  const Pose2 motion = previous.local_T_robot.inverse() * next.local_T_robot;
  const double distance = std::hypot(motion.x, motion.y);
  const double sigma = kChainRestM + kChainShare * distance;
  const double sigma_yaw = kChainRestRad + kChainTurnShare * std::abs(motion.yaw);
  // From the local frame to that of the previous key scan, in which the motion is told.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = previous.local_T_robot.rotation().transpose();
  Eigen::Matrix3d covariance = turn * (previous.covariance + next.covariance) * turn.transpose();
  covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma_yaw * sigma_yaw);
  return edge_between(from, from + 1, {motion, covariance}, EdgeKind::kOdometry);
}

}  // namespace

BackEnd::BackEnd(const MapOptions& options, Threads threads)
    : loop_closure_(options.loop_closure),
      loops_(options.loop, options.submap, options.match, threads) {}

void BackEnd::add_key(const KeyScan& key) {
  if (keys_.empty()) {
    graph_.poses.push_back(key.local_T_robot);
    travelled_m_.push_back(0.0);
  } else {
    const Pose2 motion = keys_.back().local_T_robot.inverse() * key.local_T_robot;
    graph_.edges.push_back(chain_edge(static_cast<int>(keys_.size()) - 1, keys_.back(), key));
    graph_.poses.push_back(graph_.poses.back() * motion);
    travelled_m_.push_back(travelled_m_.back() + std::hypot(motion.x, motion.y));
  }
  keys_.push_back(key);
}

void BackEnd::add_submap(FinishedSubmap submap) {
  const Stopwatch watch;
  const double travelled = travelled_m_[submap.first_key];
  loops_.add(std::move(submap), travelled);
  std::vector<LoopClosure> found;
  if (loop_closure_) found = loops_.close_newest(graph_.poses);
  loop_closing_s_ += watch.seconds();
  take(std::move(found));
}

void BackEnd::finish() {
  for (int round = 0; loop_closure_ && round < kFinalRounds; ++round) {
    const Stopwatch watch;
    auto found = loops_.close_all(graph_.poses);
    loop_closing_s_ += watch.seconds();
    take(std::move(found));
  }
  accept_lone();
  for (const auto& closure : closures_) {
    if (closure.accepted) graph_.edges.push_back(loops_.edge_of(closure));
  }
}

/// The recording is over, and no second closure will come. Strong evidence is believed without one.
void BackEnd::accept_lone() {
  bool news = false;
  for (auto& closure : closures_) {
    if (closure.accepted || closure.reason != kWaitsForWitness) continue;
    closure.accepted = closure.second_score == 0.0 && closure.overlap >= kLoneOverlap &&
                       closure.agreement >= kLoneAgreement;
    closure.reason = closure.accepted ? "" : "no second closure asks for the same";
    news = news || closure.accepted;
  }
  if (news) solve();
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
  while (accept_witnessed(closures_, {graph_.poses, travelled_m_})) {
    solve();
    news = true;
  }
  if (news) loops_.set_closures(closures_);
}

void BackEnd::solve() {
  const Stopwatch watch;
  const SolverOptions solver{.robust_kernel = "huber", .robust_width = kHuberWidth};
  while (true) {
    PoseGraph whole = graph_;
    for (const auto& closure : closures_) {
      if (closure.accepted) whole.edges.push_back(loops_.edge_of(closure));
    }
    graph_.poses = optimize(whole, solver).poses;
    // The worst closure that can't be reconciled goes; then the rest is solved again.
    LoopClosure* worst = nullptr;
    for (auto& closure : closures_) {
      if (!closure.accepted) continue;
      const auto edge = loops_.edge_of(closure);
      const Eigen::Vector3d error =
          edge_error(edge, graph_.poses[static_cast<std::size_t>(edge.from.index)],
                     graph_.poses[static_cast<std::size_t>(edge.to.index)]);
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
