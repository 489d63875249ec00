#include "loopstone/slam/loose_parts.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "slam/loose_parts_numbers.hpp"
#include "slam/map_verdict_numbers.hpp"
#include "slam/path_chain.hpp"
#include "slam/possible_error.hpp"

namespace loopstone {
namespace {

/// Of an edge that tells no more than its covariance.
bool is_open(const Eigen::Matrix3d& covariance) {
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(covariance.topLeftCorner<2, 2>());
  return axes.values(1) >
         kLooseParts.open_ratio * kLooseParts.open_ratio * std::max(axes.values(0), 0.0);
}

/// Nothing where the path has a hole.
std::optional<PathChain> chain_of(const PoseGraph& graph, std::span<const StepDrift> drifts) {
  PathChain chain;
  if (graph.poses.size() < 2) return {};
  std::vector<Eigen::Matrix3d> variances(graph.poses.size() - 1, Eigen::Matrix3d::Constant(-1.0));
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoopClosure || edge.to.index != edge.from.index + 1) continue;
    const auto at = static_cast<std::size_t>(edge.from.index);
    if (variances[at](0, 0) < 0.0) variances[at] = edge.information.inverse();
  }
  chain.travelled_m.push_back(0.0);
  for (std::size_t i = 0; i + 1 < graph.poses.size(); ++i) {
    if (variances[i](0, 0) < 0.0) return {};
    const Eigen::Matrix3d& drift = drifts.empty() ? variances[i] : drifts[i].covariance;
    chain.drifts.push_back(rotated(drift, graph.poses[i + 1].rotation()));
    chain.open.push_back(drifts.empty() ? is_open(drift) : drifts[i].open);
    chain.off.emplace_back(Eigen::Vector2d::Zero());
    if (!drifts.empty()) chain.off.back() = graph.poses[i + 1].rotation() * drifts[i].off;
    const double step_m = (graph.poses[i + 1].translation() - graph.poses[i].translation()).norm();
    chain.travelled_m.push_back(chain.travelled_m.back() + step_m);
  }
  return chain;
}

/// How well the path alone knows motions between its nodes: by its surfaces, else by its steps.
class PathKnowledge {
 public:
  /// \param across  how many recognised places lead across each edge
  PathKnowledge(const PoseGraph& graph, const PathChain& chain, const PathSurfaces& surfaces,
                std::span<const int> across)
      : poses_(graph.poses), chain_(chain), across_(across) {
    if (!surfaces.available()) return;
    posterior_.emplace(surfaces, chain, freedom_of(poses_, chain, across));
    if (!posterior_->available()) posterior_.reset();
  }

  [[nodiscard]] PossibleError possible() {
    return posterior_ ? possible_error(*posterior_) : possible_error(poses_, chain_, across_);
  }

  /// At the latter, map axes.
  [[nodiscard]] Eigen::Matrix3d between(std::size_t first, std::size_t last) {
    if (posterior_) return posterior_->between(first, last);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Eigen::Vector2d open = Eigen::Vector2d::Zero();
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector2d arm = poses_[last].translation() - poses_[i + 1].translation();
      const Eigen::Matrix3d lever = lever_of(arm);
      sum += chain_.factor * lever * chain_.drifts[i] * lever.transpose();
      if (chain_.open[i]) open += poses_[i + 1].translation() - poses_[i].translation();
    }
    // What is open is too long or too short by the same factor all along.
    open *= chain_.scale_sigma;
    sum.topLeftCorner<2, 2>() += open * open.transpose();
    return sum;
  }

  /// Of the way from first to last, without what its heading swings. Where it is not as long as
  /// odometry says, something that moves with the robot held it back.
  [[nodiscard]] double sigma_along(std::size_t first, std::size_t last) {
    const Eigen::Vector2d way = poses_[last].translation() - poses_[first].translation();
    const Eigen::Vector2d along = way.normalized();
    if (posterior_) {
      const Eigen::Matrix2d covariance = between(first, last).topLeftCorner<2, 2>();
      return std::sqrt(along.dot(covariance * along));
    }
    Eigen::Matrix2d walk = Eigen::Matrix2d::Zero();
    Eigen::Vector2d off = Eigen::Vector2d::Zero();
    for (std::size_t i = first; i < last; ++i) {
      walk += chain_.factor * chain_.drifts[i].topLeftCorner<2, 2>();
      off += chain_.off[i];
    }
    return std::sqrt(along.dot(walk * along) + std::pow(chain_.scale_sigma * way.norm(), 2) +
                     std::pow(kLooseParts.off_share * along.dot(off), 2));
  }

 private:
  std::span<const Pose2> poses_;
  const PathChain& chain_;
  std::span<const int> across_;
  std::optional<PathPosterior> posterior_{};
};

std::size_t node_at(std::span<const Stamp> stamps, Stamp stamp) {
  const auto found = std::lower_bound(stamps.begin(), stamps.end(), stamp);
  return std::min(static_cast<std::size_t>(found - stamps.begin()), stamps.size() - 1);
}

Stamp middle_of(Stamp from, Stamp to) { return {from.nanoseconds + (to - from).nanoseconds / 2}; }

/// What the path's edges measured from each node to the next.
std::vector<Pose2> steps_of(const PoseGraph& graph) {
  std::vector<Pose2> steps(graph.poses.size() - 1);
  std::vector<bool> known(steps.size(), false);
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoopClosure || edge.to.index != edge.from.index + 1) continue;
    const auto at = static_cast<std::size_t>(edge.from.index);
    if (!known[at]) steps[at] = edge.from_T_to;
    known[at] = true;
  }
  return steps;
}

/// A closure, its earlier end first.
struct Tie {
  std::size_t low;
  std::size_t high;
};

/// Between the nodes that are nearest in time.
std::vector<Tie> ties_of(std::span<const VisitTie> agreeing, std::span<const Stamp> stamps) {
  std::vector<Tie> ties;
  for (const VisitTie& tie : agreeing)
    ties.push_back({node_at(stamps, tie.first), node_at(stamps, tie.second)});
  return ties;
}

/// Closures whose both ends lie near one another along the path, joined: the first of each.
std::vector<std::vector<Tie>> recognitions(const PoseGraph& graph, const PathChain& chain,
                                           std::vector<Tie> ties) {
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind != EdgeKind::kLoopClosure) continue;
    const auto [low, high] = std::minmax(edge.from.index, edge.to.index);
    ties.push_back({static_cast<std::size_t>(low), static_cast<std::size_t>(high)});
  }
  std::stable_sort(ties.begin(), ties.end(), [](const Tie& a, const Tie& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  const auto near = [&](std::size_t a, std::size_t b) {
    return std::abs(chain.travelled_m[a] - chain.travelled_m[b]) < kLooseParts.same_place_m;
  };
  std::vector<std::vector<Tie>> groups;
  for (const Tie& tie : ties) {
    const auto same = [&](const std::vector<Tie>& group) {
      return near(group.front().low, tie.low) && near(group.front().high, tie.high);
    };
    const auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) {
      groups.push_back({tie});
    } else {
      group->push_back(tie);
    }
  }
  return groups;
}

/// How many recognitions lead across each edge of the path.
std::vector<int> ties_across(const PoseGraph& graph, const PathChain& chain,
                             std::vector<Tie> agreeing) {
  std::vector<int> change(graph.poses.size(), 0);
  for (const std::vector<Tie>& group : recognitions(graph, chain, std::move(agreeing))) {
    Tie widest = group.front();
    for (const Tie& tie : group)
      widest = {std::min(widest.low, tie.low), std::max(widest.high, tie.high)};
    ++change[widest.low];
    --change[widest.high];
  }
  change.pop_back();
  for (std::size_t i = 1; i < change.size(); ++i) change[i] += change[i - 1];
  return change;
}

Eigen::Vector2d middle_of(const PoseGraph& graph, std::size_t first, std::size_t last) {
  return graph.poses[first + (last - first) / 2].translation();
}

std::vector<LoosePart> loose_parts(const PoseGraph& graph, const PathChain& chain,
                                   std::span<const Stamp> stamps, std::span<const int> across,
                                   PathKnowledge& path) {
  std::vector<LoosePart> parts;
  for (std::size_t first = 0; first < across.size();) {
    if (across[first] > 1) {
      ++first;
      continue;
    }
    std::size_t last = first;
    while (last < across.size() && across[last] <= 1) ++last;
    const Eigen::Matrix3d covariance = path.between(first, last);
    const auto begin = across.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = across.begin() + static_cast<std::ptrdiff_t>(last);
    parts.push_back({.from = stamps[first],
                     .to = stamps[last],
                     .path_m = chain.travelled_m[last] - chain.travelled_m[first],
                     .closures = *std::min_element(begin, end),
                     .where = middle_of(graph, first, last),
                     .sigma_m = largest_sigma(covariance.topLeftCorner<2, 2>()),
                     .sigma_rad = std::sqrt(covariance(2, 2))});
    first = last;
  }
  return parts;
}

/// First and last node.
using Nodes = std::pair<std::size_t, std::size_t>;

/// Runs of edges that are open along one direction and lead the same way, the longest first.
std::vector<Nodes> open_runs(const PoseGraph& graph, const PathChain& chain) {
  std::vector<Nodes> runs;
  for (std::size_t i = 0; i < chain.open.size(); ++i) {
    if (!chain.open[i]) continue;
    const auto goes_on = [&](const Nodes& run) {
      const double turned = wrap_angle(graph.poses[i].yaw - graph.poses[run.first].yaw);
      return chain.travelled_m[i] - chain.travelled_m[run.second] <= kLooseParts.open_gap_m &&
             std::abs(turned) < kLooseParts.open_turn_rad;
    };
    if (!runs.empty() && goes_on(runs.back())) {
      runs.back().second = i + 1;
    } else {
      runs.emplace_back(i, i + 1);
    }
  }
  const auto length = [&](const Nodes& run) {
    return chain.travelled_m[run.second] - chain.travelled_m[run.first];
  };
  std::erase_if(runs, [&](const Nodes& run) { return length(run) < kLooseParts.open_least_m; });
  std::stable_sort(runs.begin(), runs.end(),
                   [&](const Nodes& a, const Nodes& b) { return length(a) > length(b); });
  if (runs.size() > static_cast<std::size_t>(kLooseParts.most_open))
    runs.resize(static_cast<std::size_t>(kLooseParts.most_open));
  return runs;
}

std::vector<OpenStretch> open_stretches(const PoseGraph& graph, const PathChain& chain,
                                        std::span<const Stamp> stamps, PathKnowledge& path) {
  std::vector<OpenStretch> stretches;
  for (const Nodes& run : open_runs(graph, chain)) {
    stretches.push_back({.from = stamps[run.first],
                         .to = stamps[run.second],
                         .path_m = chain.travelled_m[run.second] - chain.travelled_m[run.first],
                         .where = middle_of(graph, run.first, run.second),
                         .sigma_m = path.sigma_along(run.first, run.second)});
  }
  return stretches;
}

/// The motion from one node to a later one as the path measured it, by its own edges.
Pose2 measured_between(const PoseGraph& graph, std::size_t first, std::size_t last,
                       const std::vector<Pose2>& steps) {
  Pose2 motion = graph.poses[first];
  for (std::size_t i = first; i < last; ++i) motion = motion * steps[i];
  return motion;
}

/// See GraphTies::contradictions_m.
/// \param graph  at the poses that the surfaces speak of; solved: in the frame of the regions
std::vector<double> off_between_visits(const PoseGraph& graph, const PoseGraph& solved,
                                       const PathChain& chain, std::span<const Stamp> stamps,
                                       const PathSurfaces& surfaces,
                                       std::span<const VisitContradiction> contradictions) {
  const std::vector<int> no_closures(chain.drifts.size(), 0);
  PathKnowledge path(graph, chain, surfaces, no_closures);
  const std::vector<Pose2> steps = steps_of(graph);
  std::vector<double> off_m;
  for (const VisitContradiction& region : contradictions) {
    const std::size_t first = node_at(stamps, middle_of(region.first_from, region.first_to));
    const std::size_t last = node_at(stamps, middle_of(region.second_from, region.second_to));
    const Eigen::Vector2d robot_T_region = solved.poses[last].inverse() * region.centre();
    const Eigen::Vector2d at = graph.poses[last] * robot_T_region;
    const Eigen::Matrix3d there = lever_of(at - graph.poses[last].translation());
    const Eigen::Matrix3d covariance = there * path.between(first, last) * there.transpose();
    // Where the region would lie, had nothing but the path's own edges placed the second visit.
    const Pose2 by_path = measured_between(graph, first, last, steps);
    const Eigen::Vector2d moved = by_path * robot_T_region - at;
    off_m.push_back(kMapVerdict.sure_sigmas * largest_sigma(covariance.topLeftCorner<2, 2>()) +
                    moved.norm());
  }
  return off_m;
}

template <typename Part>
void least_certain_first(std::vector<Part>& parts, std::size_t most) {
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.sigma_m > b.sigma_m; });
  if (parts.size() > most) parts.resize(most);
}

}  // namespace

GraphTies find_ties_of(const PoseGraph& solved, const TieEvidence& evidence) {
  const auto& [stamps, drifts, surfaces, scale_sigma, agreeing, contradictions, loops,
               reduced_chi2] = evidence;
  GraphTies ties;
  if (stamps.size() != solved.poses.size()) return ties;
  if (!drifts.empty() && drifts.size() + 1 != solved.poses.size()) return ties;
  // Surfaces speak of the poses in whose frame they were seen.
  PathSurfaces held = surfaces;
  if (held.available() && held.poses().size() != solved.poses.size()) held = {};
  PoseGraph graph = solved;
  if (held.available()) graph.poses.assign(held.poses().begin(), held.poses().end());
  auto chain = chain_of(graph, drifts);
  if (!chain) return ties;
  if (loops >= kLooseParts.least_loops) {
    const double least = drifts.empty() ? kLooseParts.least_factor : 1.0;
    ties.variance_factor = std::clamp(reduced_chi2, least, kLooseParts.most_factor);
  }
  chain->factor = ties.variance_factor;
  chain->scale_sigma = scale_sigma;
  std::vector<int> across = ties_across(graph, *chain, ties_of(agreeing, stamps));
  // Visits that agree are no proof of where a robot was carried to: places are alike.
  const std::vector<int> closed = ties_across(graph, *chain, {});
  for (std::size_t i = 0; i < drifts.size(); ++i)
    if (drifts[i].broken) across[i] = closed[i];
  const bool any_open = std::ranges::any_of(chain->open, [](bool open) { return open; });
  // Each knowledge of the surfaces forgets the one before.
  if (any_open)
    ties.possible_beside =
        PathKnowledge(graph, with_open_ways_known(graph.poses, *chain), held, across).possible();
  PathKnowledge path(graph, *chain, held, across);
  ties.possible = path.possible();
  if (!any_open) ties.possible_beside = ties.possible;
  ties.loose = loose_parts(solved, *chain, stamps, across, path);
  ties.open = open_stretches(solved, *chain, stamps, path);
  if (!contradictions.empty())
    ties.contradictions_m = off_between_visits(graph, solved, *chain, stamps, held, contradictions);
  least_certain_first(ties.loose, static_cast<std::size_t>(kLooseParts.most_loose));
  least_certain_first(ties.open, static_cast<std::size_t>(kLooseParts.most_open));
  return ties;
}

}  // namespace loopstone
