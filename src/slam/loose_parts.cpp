#include "loopstone/slam/loose_parts.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "loopstone/geometry/covariance.hpp"
#include "loopstone/graph/marginals.hpp"
#include "slam/loose_parts_numbers.hpp"

namespace loopstone {
namespace {

/// The path from node to node.
struct Chain {
  std::vector<double> travelled_m{};         ///< at each node
  std::vector<Eigen::Matrix3d> variances{};  ///< of each edge, map axes
};

/// Nothing where the path has a hole.
std::optional<Chain> chain_of(const PoseGraph& graph) {
  Chain chain;
  if (graph.poses.size() < 2) return {};
  chain.variances.assign(graph.poses.size() - 1, Eigen::Matrix3d::Constant(-1.0));
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoopClosure || edge.to.index != edge.from.index + 1) continue;
    const auto at = static_cast<std::size_t>(edge.from.index);
    if (chain.variances[at](0, 0) >= 0.0) continue;
    chain.variances[at] = rotated(edge.information.inverse(), graph.poses[at + 1].rotation());
  }
  chain.travelled_m.push_back(0.0);
  for (std::size_t i = 0; i + 1 < graph.poses.size(); ++i) {
    if (chain.variances[i](0, 0) < 0.0) return {};
    const double step_m = (graph.poses[i + 1].translation() - graph.poses[i].translation()).norm();
    chain.travelled_m.push_back(chain.travelled_m.back() + step_m);
  }
  return chain;
}

/// Along the worst direction.
double largest_sigma_m(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>());
  return std::sqrt(std::max(axes.eigenvalues()(1), 0.0));
}

/// Of the motion between two nodes by the path alone, map axes.
Eigen::Matrix3d by_path(const PoseGraph& graph, const Chain& chain, std::size_t first,
                        std::size_t last) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector2d arm = graph.poses[last].translation() - graph.poses[i + 1].translation();
    Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
    lever(0, 2) = -arm.y();
    lever(1, 2) = arm.x();
    sum += lever * chain.variances[i] * lever.transpose();
  }
  return sum;
}

/// A closure, its earlier end first.
struct Tie {
  std::size_t low;
  std::size_t high;
};

/// Between the nodes that are nearest in time.
std::vector<Tie> ties_of(std::span<const VisitTie> agreeing, std::span<const Stamp> stamps) {
  const auto node_at = [&](Stamp stamp) {
    const auto found = std::lower_bound(stamps.begin(), stamps.end(), stamp);
    return std::min(static_cast<std::size_t>(found - stamps.begin()), stamps.size() - 1);
  };
  std::vector<Tie> ties;
  for (const VisitTie& tie : agreeing) ties.push_back({node_at(tie.first), node_at(tie.second)});
  return ties;
}

/// Closures whose both ends lie near one another along the path, joined: the first of each.
std::vector<std::vector<Tie>> recognitions(const PoseGraph& graph, const Chain& chain,
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
std::vector<int> ties_across(const PoseGraph& graph, const Chain& chain,
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

std::vector<LoosePart> loose_parts(const PoseGraph& graph, const Chain& chain,
                                   std::span<const Stamp> stamps, std::vector<Tie> agreeing,
                                   double factor) {
  const std::vector<int> across = ties_across(graph, chain, std::move(agreeing));
  std::vector<LoosePart> parts;
  for (std::size_t first = 0; first < across.size();) {
    if (across[first] > 1) {
      ++first;
      continue;
    }
    std::size_t last = first;
    while (last < across.size() && across[last] <= 1) ++last;
    const Eigen::Matrix3d covariance = factor * by_path(graph, chain, first, last);
    const auto begin = across.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = across.begin() + static_cast<std::ptrdiff_t>(last);
    parts.push_back({.from = stamps[first],
                     .to = stamps[last],
                     .path_m = chain.travelled_m[last] - chain.travelled_m[first],
                     .closures = *std::min_element(begin, end),
                     .where = middle_of(graph, first, last),
                     .sigma_m = largest_sigma_m(covariance),
                     .sigma_rad = std::sqrt(covariance(2, 2))});
    first = last;
  }
  return parts;
}

/// First and last node.
using Nodes = std::pair<std::size_t, std::size_t>;

/// Runs of edges that are open along one direction, the longest first.
std::vector<Nodes> open_runs(const Chain& chain) {
  std::vector<Nodes> runs;
  for (std::size_t i = 0; i < chain.variances.size(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
        chain.variances[i].topLeftCorner<2, 2>());
    const double across_m = std::sqrt(std::max(axes.eigenvalues()(0), 0.0));
    const double along_m = std::sqrt(std::max(axes.eigenvalues()(1), 0.0));
    const double step_m = chain.travelled_m[i + 1] - chain.travelled_m[i];
    if (along_m < kLooseParts.open_ratio * across_m || along_m < kLooseParts.open_share * step_m)
      continue;
    if (!runs.empty() &&
        chain.travelled_m[i] - chain.travelled_m[runs.back().second] <= kLooseParts.open_gap_m) {
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

std::vector<OpenStretch> open_stretches(const PoseGraph& graph, const Chain& chain,
                                        std::span<const Stamp> stamps, double factor) {
  const std::vector<Nodes> runs = open_runs(chain);
  std::vector<std::pair<NodeId, NodeId>> pairs;
  for (const auto& [first, last] : runs)
    pairs.emplace_back(NodeId{static_cast<int>(first)}, NodeId{static_cast<int>(last)});
  std::vector<OpenStretch> stretches;
  if (runs.empty()) return stretches;
  const PairMarginals known = joint_covariances(graph, pairs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto& [first, last] = runs[i];
    const Eigen::Matrix3d covariance =
        known.available
            ? relative_covariance(graph.poses[first], graph.poses[last], known.covariances[i])
            : by_path(graph, chain, first, last);
    stretches.push_back({.from = stamps[first],
                         .to = stamps[last],
                         .path_m = chain.travelled_m[last] - chain.travelled_m[first],
                         .where = middle_of(graph, first, last),
                         .sigma_m = std::sqrt(factor) * largest_sigma_m(covariance),
                         .sigma_rad = std::sqrt(factor * std::max(covariance(2, 2), 0.0))});
  }
  return stretches;
}

template <typename Part>
void least_certain_first(std::vector<Part>& parts, std::size_t most) {
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.sigma_m > b.sigma_m; });
  if (parts.size() > most) parts.resize(most);
}

}  // namespace

GraphTies find_ties_of(const PoseGraph& solved, std::span<const Stamp> stamps,
                       std::span<const VisitTie> agreeing, int loops, double reduced_chi2) {
  GraphTies ties;
  if (stamps.size() != solved.poses.size()) return ties;
  const auto chain = chain_of(solved);
  if (!chain) return ties;
  if (loops >= kLooseParts.least_loops)
    ties.variance_factor =
        std::clamp(reduced_chi2, kLooseParts.least_factor, kLooseParts.most_factor);
  ties.loose = loose_parts(solved, *chain, stamps, ties_of(agreeing, stamps), ties.variance_factor);
  ties.open = open_stretches(solved, *chain, stamps, ties.variance_factor);
  least_certain_first(ties.loose, static_cast<std::size_t>(kLooseParts.most_loose));
  least_certain_first(ties.open, static_cast<std::size_t>(kLooseParts.most_open));
  return ties;
}

}  // namespace loopstone
