#include "loopstone/slam/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kProbePoints = 350;
/// Submaps this close in sequence share scans or are tied tightly already.
constexpr std::size_t kNeighbours = 2;
/// Uncertainty where two places are connected directly.
constexpr double kRestM = 0.35;
constexpr double kRestRad = 0.06;
constexpr double kMaxHalfYawRad = 0.8;
/// Travelling through a closure costs this much travel.
constexpr double kClosureTravelM = 1.0;
/// What a whole submap's own bending adds to the uncertainty of a closure.
constexpr double kBendM = 0.03;
constexpr double kBendRad = 0.005;
/// A pair that failed is tried again once its poses have changed by this much.
constexpr double kSameTryM = 0.25;
constexpr double kSameTryRad = 0.03;
/// A pose this far from the best one is another place.
constexpr double kElsewhereM = 1.0;
constexpr double kElsewhereRad = 0.35;

}  // namespace

struct LoopCloser::Entry {
  FrozenSubmap submap;
  std::size_t first_key = 0;
  std::size_t last_key = 0;
  double travelled_m = 0.0;
  Eigen::Vector2d centre;  // of its surfaces, submap frame
  double radius_m = 0.0;   // rms distance of its surfaces from the centre
};

struct LoopCloser::Pair {
  std::size_t older;
  std::size_t newer;
  Pose2 older_T_newer;  // at the present poses
  double half_xy_m;
  double half_yaw_rad;
  double distance_m;
};

LoopCloser::LoopCloser(const LoopOptions& options, const SubmapOptions& submap,
                       const GridMatchOptions& match, Threads threads)
    : options_(options), submap_options_(submap), match_options_(match), threads_(threads) {}

LoopCloser::~LoopCloser() = default;
LoopCloser::LoopCloser(LoopCloser&&) noexcept = default;
LoopCloser& LoopCloser::operator=(LoopCloser&&) noexcept = default;

std::size_t LoopCloser::submap_count() const { return entries_.size(); }

void LoopCloser::add(FinishedSubmap submap, double travelled_m) {
  Entry entry{.submap = std::move(submap.submap),
              .first_key = submap.first_key,
              .last_key = submap.last_key,
              .travelled_m = travelled_m,
              .centre = Eigen::Vector2d::Zero(),
              .radius_m = 0.0};
  const auto& surfaces = entry.submap.surfaces;
  if (!surfaces.empty()) {
    for (const auto& surface : surfaces) entry.centre += surface.position.cast<double>();
    entry.centre /= static_cast<double>(surfaces.size());
    double sum = 0.0;
    for (const auto& surface : surfaces)
      sum += (surface.position.cast<double>() - entry.centre).squaredNorm();
    entry.radius_m = std::sqrt(sum / static_cast<double>(surfaces.size()));
  }
  entries_.push_back(std::move(entry));
}

void LoopCloser::set_closures(std::span<const LoopClosure> closures) {
  standing_.clear();
  for (const auto& closure : closures) {
    if (closure.accepted) standing_.push_back(closure);
  }
}

std::vector<double> LoopCloser::travel_between(std::size_t from) const {
  // Dijkstra over submaps: neighbours in sequence by the path between them, closures at a fixed price.
  std::vector<std::vector<std::pair<std::size_t, double>>> links(entries_.size());
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    const double travel = entries_[i].travelled_m - entries_[i - 1].travelled_m;
    links[i].push_back({i - 1, travel});
    links[i - 1].push_back({i, travel});
  }
  for (const auto& closure : standing_) {
    links[closure.from_submap].push_back({closure.to_submap, kClosureTravelM});
    links[closure.to_submap].push_back({closure.from_submap, kClosureTravelM});
  }
  std::vector<double> travel(entries_.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  travel[from] = 0.0;
  open.push({0.0, from});
  while (!open.empty()) {
    const auto [cost, at] = open.top();
    open.pop();
    if (cost > travel[at]) continue;
    for (const auto& [next, step] : links[at]) {
      if (cost + step >= travel[next]) continue;
      travel[next] = cost + step;
      open.push({travel[next], next});
    }
  }
  return travel;
}

std::vector<LoopCloser::Pair> LoopCloser::candidates_for(std::size_t newer,
                                                         std::span<const Pose2> map_T_key) const {
  std::vector<Pair> pairs;
  const Entry& query = entries_[newer];
  const Pose2 map_T_newer = map_T_key[query.first_key];
  const Eigen::Vector2d centre = map_T_newer * query.centre;
  const auto travel = travel_between(newer);
  for (std::size_t older = 0; older + kNeighbours < newer; ++older) {
    const bool closed =
        std::any_of(standing_.begin(), standing_.end(), [&](const LoopClosure& closure) {
          return closure.from_submap == older && closure.to_submap == newer;
        });
    if (closed) continue;
    const Entry& target = entries_[older];
    const Pose2 map_T_older = map_T_key[target.first_key];
    Pair pair{.older = older,
              .newer = newer,
              .older_T_newer = map_T_older.inverse() * map_T_newer,
              .half_xy_m =
                  std::min(kRestM + options_.drift_per_m * travel[older], options_.max_half_xy_m),
              .half_yaw_rad =
                  std::min(kRestRad + options_.drift_rad_per_m * travel[older], kMaxHalfYawRad),
              .distance_m = (centre - map_T_older * target.centre).norm()};
    if (pair.distance_m > 0.7 * (query.radius_m + target.radius_m) + pair.half_xy_m) continue;
    if (was_tried(pair)) continue;
    pairs.push_back(pair);
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
  if (pairs.size() > static_cast<std::size_t>(options_.candidates_max)) {
    pairs.resize(static_cast<std::size_t>(options_.candidates_max));
  }
  return pairs;
}

bool LoopCloser::was_tried(const Pair& pair) const {
  const auto tried = tried_.find({pair.older, pair.newer});
  if (tried == tried_.end()) return false;
  const Pose2 change = tried->second.inverse() * pair.older_T_newer;
  return std::hypot(change.x, change.y) < kSameTryM && std::abs(change.yaw) < kSameTryRad;
}

std::vector<LoopClosure> LoopCloser::close_newest(std::span<const Pose2> map_T_key) {
  return compare(candidates_for(entries_.size() - 1, map_T_key));
}

std::vector<LoopClosure> LoopCloser::close_all(std::span<const Pose2> map_T_key) {
  std::vector<Pair> pairs;
  for (std::size_t newer = kNeighbours + 1; newer < entries_.size(); ++newer) {
    const auto more = candidates_for(newer, map_T_key);
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  return compare(pairs);
}

std::vector<LoopClosure> LoopCloser::compare(const std::vector<Pair>& pairs) {
  for (const Pair& pair : pairs) tried_[{pair.older, pair.newer}] = pair.older_T_newer;
  std::vector<std::optional<LoopClosure>> found(pairs.size());
  parallel_for(pairs.size(), threads_, [&](std::size_t index) {
    const Pair& pair = pairs[index];
    const Entry& target = entries_[pair.older];
    const Entry& query = entries_[pair.newer];
    const auto probe = query.submap.probe(kProbePoints);
    if (probe.empty() || target.submap.surfaces.empty()) return;
    const MaxPyramid pyramid = target.submap.search_pyramid(submap_options_, pair.half_xy_m);
    const SearchWindow window{pair.older_T_newer, pair.half_xy_m, pair.half_yaw_rad};
    const SearchResult best = search_branch_and_bound(probe, pyramid, window, options_.min_score);
    if (!best.found) return;

    LoopClosure closure;
    closure.from = NodeId{static_cast<int>(target.first_key)};
    closure.to = NodeId{static_cast<int>(query.first_key)};
    closure.from_submap = pair.older;
    closure.to_submap = pair.newer;
    closure.score = best.score;
    // In a small window there is no elsewhere.
    SearchResult second;
    if (pair.half_xy_m > 0.5 * kElsewhereM || pair.half_yaw_rad > 0.5 * kElsewhereRad) {
      second =
          search_branch_and_bound(probe, pyramid, window, options_.max_ambiguity * best.score,
                                  ExcludedPoses{best.target_T_source, kElsewhereM, kElsewhereRad});
    }
    closure.second_score = second.found ? second.score : 0.0;

    const SurfaceGrid surfaces = target.submap.surface_grid(submap_options_);
    const MatchResult match =
        match_to_grid(query.submap.surfaces, surfaces, best.target_T_source, {}, match_options_, 0);
    closure.from_T_to = match.target_T_source;
    closure.covariance = match.covariance;
    closure.covariance.diagonal() +=
        Eigen::Vector3d(kBendM * kBendM, kBendM * kBendM, kBendRad * kBendRad);

    std::size_t seen = 0;
    for (const auto& surface : query.submap.surfaces) {
      const Cell cell =
          pyramid.frame().cell_of(match.target_T_source * surface.position.cast<double>().eval());
      if (pyramid.bound(0, cell.column, cell.row) != kUnknown) ++seen;
    }
    closure.overlap = static_cast<double>(seen) / static_cast<double>(query.submap.surfaces.size());
    closure.agreement = closure.overlap > 0.0 ? std::min(1.0, match.score / closure.overlap) : 0.0;

    if (match.status == MatchStatus::kTooFewPairs) {
      closure.reason = "refinement found too few pairs";
    } else if (second.found) {
      closure.reason = "ambiguous: another pose scores nearly as well";
    } else if (closure.overlap < options_.min_overlap) {
      closure.reason = "too little overlap";
    } else if (closure.agreement < options_.min_agreement) {
      closure.reason = "surfaces disagree";
    } else {
      closure.accepted = true;
    }
    found[index] = closure;
  });
  std::vector<LoopClosure> closures;
  for (auto& closure : found) {
    if (closure) closures.push_back(std::move(*closure));
  }
  return closures;
}

RelativePoseEdge LoopCloser::edge_of(const LoopClosure& closure) const {
  return edge_between(closure.from.index, closure.to.index, {closure.from_T_to, closure.covariance},
                      EdgeKind::kLoopClosure);
}

}  // namespace loopstone
