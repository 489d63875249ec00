#include "slam/edit_closures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/graph/marginals.hpp"
#include "slam/closure_solution.hpp"
#include "slam/drives.hpp"
#include "slam/hand_closure.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/rival_places.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::pair<NodeId, NodeId> nodes_of(const LoopClosure& closure) {
  return {closure.from, closure.to};
}

/// With the closures that stand.
void solve(EditState& state) {
  PoseGraph& graph = state.settled.graph;
  std::erase_if(graph.edges,
                [](const RelativePoseEdge& edge) { return edge.kind == EdgeKind::kLoopClosure; });
  solve_closures(
      graph, state.settled.closures,
      [&](const LoopClosure& closure) { return !state.forced.contains(nodes_of(closure)); }, {});
  for (const LoopClosure& closure : state.settled.closures)
    if (closure.stands()) graph.edges.push_back(edge_of(closure));
}

void take_out(LoopClosure& closure, ClosureReason reason) {
  closure.state = ClosureState::kRejected;
  closure.reason = reason;
  closure.chi2.reset();
}

std::string told_closure(const LoopClosure& closure, const EditedPath& path) {
  return fmt::format("the closure from {} to {} (submaps {} and {})",
                     path.told(static_cast<std::size_t>(closure.from.index)),
                     path.told(static_cast<std::size_t>(closure.to.index)),
                     closure.from_submap.index, closure.to_submap.index);
}

/// How far the ends of a closure are from two nodes in time [s], the farther one.
double apart_s(const LoopClosure& closure, std::size_t from, std::size_t to,
               const EditedPath& path) {
  const auto off = [&](NodeId node, std::size_t other) {
    return std::abs(
        (path.keys[static_cast<std::size_t>(node.index)].stamp - path.keys[other].stamp).seconds());
  };
  return std::max(off(closure.from, from), off(closure.to, to));
}

/// Those that stand come first, then by how near they are.
struct Meant {
  std::size_t place = 0;
  double apart_s = kInfinite;
};

Meant nearest_to(std::size_t from, std::size_t to, bool stands,
                 std::span<const LoopClosure> closures, const EditedPath& path) {
  Meant meant;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    if (closures[i].stands() != stands) continue;
    const double off = apart_s(closures[i], from, to, path);
    if (off < meant.apart_s) meant = {i, off};
  }
  return meant;
}

[[noreturn]] void refuse_none(const std::string& what, const LoopClosure* other,
                              const EditedPath& path) {
  std::string why = what;
  if (other != nullptr) {
    why += fmt::format("; {} does not stand: {}", told_closure(*other, path),
                       to_string(other->reason));
  }
  throw EditRefusal(why);
}

/// The place of the closure that is meant.
std::size_t meant_by_submaps(const DeleteClosure& edit, std::span<const LoopClosure> closures,
                             const EditedPath& path) {
  const auto [older, newer] = std::minmax({*edit.from_submap, *edit.to_submap});
  const LoopClosure* other = nullptr;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& closure = closures[i];
    if (static_cast<std::int64_t>(closure.from_submap.index) != older ||
        static_cast<std::int64_t>(closure.to_submap.index) != newer)
      continue;
    if (closure.stands()) return i;
    other = &closure;
  }
  refuse_none(fmt::format("no closure stands between submaps {} and {}", older, newer), other,
              path);
}

std::size_t meant_by_places(const DeleteClosure& edit, std::span<const LoopClosure> closures,
                            const EditedPath& path) {
  const auto [from, to] = std::minmax({node_of(edit.from, path), node_of(edit.to, path)});
  const Meant meant = nearest_to(from, to, true, closures, path);
  if (meant.apart_s <= kMapEditor.same_closure_s) return meant.place;
  std::string what = fmt::format("no closure stands within {:.0f} s of {} and {}",
                                 kMapEditor.same_closure_s, path.told(from), path.told(to));
  if (std::isfinite(meant.apart_s))
    what += "; the nearest is " + told_closure(closures[meant.place], path);
  const Meant other = nearest_to(from, to, false, closures, path);
  refuse_none(what, other.apart_s <= kMapEditor.same_closure_s ? &closures[other.place] : nullptr,
              path);
}

/// Of each submap where it begins and what it is closed with now.
std::vector<SubmapRecord> tied_submaps(const EditedPath& path, const EditState& state) {
  const std::span<const SubmapRecord> all = path.map->chain.submaps();
  std::vector<SubmapRecord> submaps(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    submaps[i].keys = {all[i].keys.front()};
    submaps[i].travelled_m = all[i].travelled_m;
  }
  for (const LoopClosure& closure : state.settled.closures) {
    if (!closure.stands()) continue;
    submaps[closure.from_submap.index].closed_with.push_back(closure.to_submap);
    submaps[closure.to_submap.index].closed_with.push_back(closure.from_submap);
  }
  return submaps;
}

/// What the graph knows of the way from one node to another.
struct KnownMotion {
  Pose2 from_T_to{};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool available = false;
};

/// With what the covariances of a path do not know, by the shortest way there: is_likely() asks the
/// same of submaps.
KnownMotion known_motion(NodeId from, NodeId to, const EditedPath& path, const EditState& state) {
  const PoseGraph& graph = state.settled.graph;
  const Pose2& map_T_from = graph.poses[static_cast<std::size_t>(from.index)];
  const Pose2& map_T_to = graph.poses[static_cast<std::size_t>(to.index)];
  KnownMotion known{.from_T_to = map_T_from.inverse() * map_T_to};
  const std::array pairs{std::pair{from, to}};
  const PairMarginals marginals = joint_covariances(graph, pairs);
  if (!marginals.available) return known;
  const SubmapId start = path.submap_of(static_cast<std::size_t>(from.index));
  const SubmapId end = path.submap_of(static_cast<std::size_t>(to.index));
  const double travel_m = travel_from(tied_submaps(path, state), start, kInfinite)[end.index];
  if (!std::isfinite(travel_m)) return known;
  known.available = true;
  known.covariance =
      relative_covariance(map_T_from, map_T_to, marginals.covariances.front()) +
      planar_covariance(kLoopCandidates.rest_m + kRivalPlaces.drift_per_m * travel_m,
                        kLoopCandidates.rest_rad + kRivalPlaces.drift_rad_per_m * travel_m);
  return known;
}

/// Whether nothing ties the drives of two nodes, and the nodes that hang together with the later.
struct Adrift {
  bool is_adrift = false;
  std::vector<SubmapId> with_later{};
};

Adrift adrift_of(std::size_t from, std::size_t to, const EditedPath& path, const EditState& state) {
  const Drives drives(tied_submaps(path, state));
  if (!drives.are_adrift(path.submap_of(from), path.submap_of(to))) return {};
  return {true, drives.with(path.submap_of(to))};
}

/// Lays what is adrift where a closure puts it: solving has to turn it by little then.
void lay(const LoopClosure& closure, const Adrift& adrift, const EditedPath& path,
         EditState& state) {
  std::vector<Pose2>& poses = state.settled.graph.poses;
  const Pose2 to_T_now = poses[static_cast<std::size_t>(closure.from.index)] * closure.from_T_to *
                         poses[static_cast<std::size_t>(closure.to.index)].inverse();
  for (const SubmapId submap : adrift.with_later) {
    const auto first = static_cast<std::size_t>(path.first_nodes[submap.index].index);
    const std::size_t end = submap.index + 1 < path.first_nodes.size()
                                ? static_cast<std::size_t>(path.first_nodes[submap.index + 1].index)
                                : poses.size();
    for (std::size_t node = first; node < end; ++node) poses[node] = to_T_now * poses[node];
  }
}

std::string figures_of(const LoopClosure& closure, const LoopOptions& asked) {
  return fmt::format(
      "score {:.2f} ({:.2f} asked), overlap {:.2f} ({:.2f}), agreement {:.2f} "
      "({:.2f})",
      closure.score, asked.min_score, closure.overlap, asked.min_overlap, closure.agreement,
      asked.min_agreement);
}

/// Why a closure is not believed though its scans fit; empty: it is.
std::string doubt_about(const LoopClosure& closure, const KnownMotion& known, bool guessed) {
  if (closure.second_score && !guessed) {
    return fmt::format(
        "another pose in the window scores nearly as well ({:.2f}); a guess (x_m, "
        "y_m, yaw_rad) says which is meant",
        *closure.second_score);
  }
  if (!known.available) return {};
  const Eigen::Vector3d off(closure.from_T_to.x - known.from_T_to.x,
                            closure.from_T_to.y - known.from_T_to.y,
                            wrap_angle(closure.from_T_to.yaw - known.from_T_to.yaw));
  const Eigen::Matrix3d covariance = known.covariance + closure.covariance;
  const double chi2 = off.dot(solve_symmetric(covariance, off));
  if (chi2 <= kRivalPlaces.unlikely_chi2) return {};
  return fmt::format(
      "it lies {:.2f} m and {:.1f} deg from where the rest of the map puts it, which "
      "is {:.1f} standard deviations: two places that look alike, more likely",
      off.head<2>().norm(), degrees(std::abs(off[2])), std::sqrt(chi2));
}

/// What nothing but somebody's word says.
LoopClosure as_told(const HandCandidate& candidate, const EditedPath& path) {
  LoopClosure closure{.from = NodeId{static_cast<int>(candidate.from)},
                      .to = NodeId{static_cast<int>(candidate.to)},
                      .from_submap = path.submap_of(candidate.from),
                      .to_submap = path.submap_of(candidate.to),
                      .from_T_to = candidate.from_T_to};
  closure.covariance = planar_covariance(kMapEditor.told_m, kMapEditor.told_rad);
  return closure;
}

/// In which order the two places are on the path, and where the later is looked for.
HandCandidate candidate_of(const AddClosure& edit, bool is_adrift, const EditedPath& path,
                           const Pose2& told_T_path, const EditState& state) {
  const std::size_t from = node_of(edit.from, path);
  const std::size_t to = node_of(edit.to, path);
  HandCandidate candidate{.from = std::min(from, to), .to = std::max(from, to)};
  const double near_m = 0.5 * path.map->options.front_end.submap_length_m;
  candidate.from_nodes = nodes_around(candidate.from, near_m, path);
  candidate.to_nodes = nodes_around(candidate.to, near_m, path);
  const LoopOptions& loop = path.map->options.loop;
  candidate.half_xy_m = edit.half_window_m.value_or(loop.max_half_xy_m);
  candidate.half_yaw_rad = edit.half_window_rad.value_or(kLoopCandidates.half_yaw_most_rad);
  if (edit.guess_from_T_to) {
    const Pose2 guess = told_T_path.inverse() * *edit.guess_from_T_to * told_T_path;
    candidate.from_T_to = from <= to ? guess : guess.inverse();
    candidate.half_xy_m = edit.half_window_m.value_or(kMapEditor.guess_half_m);
    candidate.half_yaw_rad = edit.half_window_rad.value_or(kMapEditor.guess_half_rad);
  } else if (is_adrift) {
    // No path leads there: the places lie on one another, facing anywhere.
    candidate.half_yaw_rad = edit.half_window_rad.value_or(kPi);
  } else {
    const std::vector<Pose2>& poses = state.settled.graph.poses;
    candidate.from_T_to = poses[candidate.from].inverse() * poses[candidate.to];
  }
  return candidate;
}

bool waits(const LoopClosure& closure) { return closure.state == ClosureState::kWaiting; }

/// A submap holds the scans of its stretch and of the next one.
NodeRange nodes_of_submap(SubmapId submap, const EditedPath& path) {
  const std::size_t after = submap.index + 2;
  const auto begin = static_cast<std::size_t>(path.first_nodes[submap.index].index);
  return {begin, after < path.first_nodes.size()
                     ? static_cast<std::size_t>(path.first_nodes[after].index) - 1
                     : path.keys.size() - 1};
}

/// By the scans right around the places; where these see too little of one another, by those of the
/// submaps that they lie in, which is how loop_closures.csv names closures; else by twice as many
/// around.
std::optional<LoopClosure> best_of_all_reaches(HandCandidate candidate, const EditedPath& path,
                                               const EditState& state) {
  const auto ignores = [&](std::size_t scan) { return state.ignores(scan); };
  const double far_m = path.map->options.front_end.submap_length_m;
  const auto of_submap = [&](std::size_t node) {
    return nodes_of_submap(path.submap_of(node), path);
  };
  const std::array reaches{std::pair{candidate.from_nodes, candidate.to_nodes},
                           std::pair{of_submap(candidate.from), of_submap(candidate.to)},
                           std::pair{nodes_around(candidate.from, far_m, path),
                                     nodes_around(candidate.to, far_m, path)}};
  std::optional<LoopClosure> best;
  for (const auto& [from_nodes, to_nodes] : reaches) {
    candidate.from_nodes = from_nodes;
    candidate.to_nodes = to_nodes;
    auto found = register_places(candidate, path, ignores);
    if (found && waits(*found)) return found;
    if (found && (!best || found->score > best->score)) best = found;
  }
  return best;
}

/// The measured closure, or the reason why there is none.
LoopClosure measure(const AddClosure& edit, const HandCandidate& candidate, const EditedPath& path,
                    const EditState& state) {
  const LoopOptions& asked = path.map->options.loop;
  const auto found = best_of_all_reaches(candidate, path, state);
  const bool fits = found && waits(*found);
  if (edit.force && !fits && edit.guess_from_T_to) return as_told(candidate, path);
  const std::string window =
      fmt::format("{:.1f} m and {:.0f} deg", candidate.half_xy_m, degrees(candidate.half_yaw_rad));
  if (!found) {
    throw EditRefusal(
        fmt::format("no pose within {} scores {:.2f}: the scans around the places do "
                    "not show the same walls there{}",
                    window, asked.min_score,
                    edit.force ? "; to force it, tell the pose (x_m, y_m, yaw_rad)" : ""));
  }
  if (!fits && !edit.force) {
    throw ClosureRefusal(fmt::format("{}: {}", to_string(found->reason), figures_of(*found, asked)),
                         *found);
  }
  return *found;
}

/// Nodes whose scans are of one submap are tied by the path already.
void refuse_neighbours(const HandCandidate& candidate) {
  if (candidate.from_nodes.last < candidate.to_nodes.first) return;
  throw EditRefusal(
      "the two places are neighbours on the path, whose scans are aligned to one another already");
}

/// The scans that a closure was measured by, or about so, to do so again.
HandCandidate again_of(const LoopClosure& closure, const EditedPath& path) {
  const auto from = static_cast<std::size_t>(closure.from.index);
  const auto to = static_cast<std::size_t>(closure.to.index);
  const double far_m = path.map->options.front_end.submap_length_m;
  const bool by_hand = closure.reason == ClosureReason::kAddedByHand;
  const auto around = [&](std::size_t node, SubmapId submap) {
    return by_hand ? nodes_around(node, far_m, path) : nodes_of_submap(submap, path);
  };
  return {.from = from,
          .to = to,
          .from_nodes = around(from, closure.from_submap),
          .to_nodes = around(to, closure.to_submap),
          .from_T_to = closure.from_T_to,
          .half_xy_m = kMapEditor.again_half_m,
          .half_yaw_rad = kMapEditor.again_half_rad};
}

}  // namespace

ClosureEdit delete_closure(const DeleteClosure& edit, const EditedPath& path, EditState& state) {
  std::vector<LoopClosure>& closures = state.settled.closures;
  const std::size_t place = edit.from_submap ? meant_by_submaps(edit, closures, path)
                                             : meant_by_places(edit, closures, path);
  LoopClosure& closure = closures[place];
  const std::string told = told_closure(closure, path) + " is out";
  state.forced.erase(nodes_of(closure));
  take_out(closure, ClosureReason::kDeletedByHand);
  const LoopClosure deleted = closure;
  solve(state);
  return {told, deleted};
}

ClosureEdit add_closure(const AddClosure& edit, const EditedPath& path, const Pose2& told_T_path,
                        EditState& state) {
  const auto [first, last] = std::minmax({node_of(edit.from, path), node_of(edit.to, path)});
  const Adrift adrift = adrift_of(first, last, path, state);
  const HandCandidate candidate = candidate_of(edit, adrift.is_adrift, path, told_T_path, state);
  refuse_neighbours(candidate);
  LoopClosure closure = measure(edit, candidate, path, state);
  const std::string figures = figures_of(closure, path.map->options.loop);
  const KnownMotion known =
      adrift.is_adrift ? KnownMotion{} : known_motion(closure.from, closure.to, path, state);
  const std::string doubt = doubt_about(closure, known, edit.guess_from_T_to.has_value());
  if (!doubt.empty() && !edit.force) throw ClosureRefusal(doubt + "; " + figures, closure);
  closure.state = ClosureState::kStanding;
  closure.reason = ClosureReason::kAddedByHand;
  if (edit.force) state.forced.insert(nodes_of(closure));
  if (adrift.is_adrift) lay(closure, adrift, path, state);
  const std::size_t place = state.settled.closures.size();
  state.settled.closures.push_back(closure);
  solve(state);
  const LoopClosure& solved = state.settled.closures[place];
  if (!solved.stands()) {
    throw ClosureRefusal(fmt::format("it contradicts the rest of the map (chi-square {:.0f}); {}",
                                     *solved.chi2, figures),
                         solved);
  }
  std::string told = told_closure(solved, path) + " stands; " + figures +
                     fmt::format(", chi-square {:.1f}", *solved.chi2);
  if (edit.force && !doubt.empty()) told += "; forced, though " + doubt;
  return {told, solved};
}

ClosureEdit ignore_stretch(const IgnoreStretch& edit, const EditedPath& path, EditState& state) {
  const auto [first, last] = std::minmax({node_of(edit.from, path), node_of(edit.to, path)});
  state.ignored.push_back({path.keys[first].scan, path.keys[last].scan});
  const auto ignores = [&](std::size_t scan) { return state.ignores(scan); };
  const auto touches = [first = first, last = last](const NodeRange& range) {
    return range.first <= last && range.last >= first;
  };
  int again = 0;
  int lost = 0;
  for (LoopClosure& closure : state.settled.closures) {
    if (!closure.stands() || state.forced.contains(nodes_of(closure))) continue;
    const HandCandidate candidate = again_of(closure, path);
    if (!touches(candidate.from_nodes) && !touches(candidate.to_nodes)) continue;
    const auto found = register_places(candidate, path, ignores);
    if (found && found->state == ClosureState::kWaiting) {
      const ClosureReason reason = closure.reason;
      closure = *found;
      closure.state = ClosureState::kStanding;
      closure.reason = reason;
      ++again;
    } else {
      take_out(closure, ClosureReason::kIgnored);
      ++lost;
    }
  }
  if (again + lost > 0) solve(state);
  return {fmt::format("scans from {} to {} are not used; of the closures that saw them, {} {} "
                      "measured again without them and {} {} out",
                      path.told(first), path.told(last), again, again == 1 ? "was" : "were", lost,
                      lost == 1 ? "is" : "are"),
          {}};
}

}  // namespace loopstone
