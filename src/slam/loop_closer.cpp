#include "loopstone/slam/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "slam/place_descriptor.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kProbePoints = 350;
/// Submaps this close in sequence on one piece of the path share scans or are tied tightly already.
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
/// Two places that look alike are laid centre on centre, give or take what each one saw more of on one side.
constexpr double kPlaceHalfM = 5.0;
/// What was found without a pose's help must score at least this.
constexpr double kPlaceScore = 0.5;
constexpr double kPlaceOverlap = 0.5;
constexpr double kPlaceAgreement = 0.85;
/// Less alike than this share of the middle one of all that come into question: another place. Of true ones 19 in 20 are
/// more alike.
constexpr double kUnlike = 0.8;
/// A submap of which older ones saw so much adds nothing.
constexpr double kCovered = 0.9;
/// So many are compared beside each other, whatever the number of threads; the nearest first, until the submap is covered.
constexpr std::size_t kBeside = 2;
/// In the end so many, some tenths of a second, before somebody is asked whether to go on.
constexpr std::size_t kAtOnce = 64;

/// Which of the surfaces fall where a submap was observed.
std::vector<bool> seen_by(const MaxPyramid& target, const Pose2& target_T_source,
                          std::span<const SurfacePoint> surfaces) {
  std::vector<bool> seen;
  seen.reserve(surfaces.size());
  for (const SurfacePoint& surface : surfaces) {
    const Cell cell =
        target.frame().cell_of(target_T_source * surface.position.cast<double>().eval());
    seen.push_back(target.bound(0, cell.column, cell.row) != kUnknown);
  }
  return seen;
}

void add_to(std::vector<bool>& seen, const std::vector<bool>& more) {
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = seen[i] || more[i];
}

double share_of(const std::vector<bool>& seen) {
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) /
         static_cast<double>(seen.size());
}

}  // namespace

struct LoopCloser::Entry {
  FrozenSubmap submap;
  std::size_t piece = 0;
  double travelled_m = 0.0;
  Eigen::Vector2d centre;  // of its surfaces, submap frame
  double radius_m = 0.0;   // rms distance of its surfaces from the centre
  std::vector<std::size_t> closed_with{};
  std::vector<float> looks{};  // of the place, once somebody asked; follows from the submap
  bool dropped = false;

  template <typename Archive>
  void archive(Archive& a) {
    a(submap, piece, travelled_m, centre, radius_m, closed_with, dropped);
  }
};

struct LoopCloser::Pair {
  std::size_t older;
  std::size_t newer;
  Pose2 older_T_newer;  // at the present poses
  double half_xy_m;
  double half_yaw_rad;
  double distance_m;
  bool place = false;  // taken for its looks, not for its pose
};

LoopCloser::LoopCloser(const LoopOptions& options, const SubmapOptions& submap,
                       const GridMatchOptions& match, Threads threads)
    : options_(options), submap_options_(submap), match_options_(match), threads_(threads) {}

LoopCloser::~LoopCloser() = default;
LoopCloser::LoopCloser(LoopCloser&&) noexcept = default;
LoopCloser& LoopCloser::operator=(LoopCloser&&) noexcept = default;

template <typename Archive>
void LoopCloser::archive_fields(Archive& a) {
  a(entries_, standing_, tried_, tried_places_, seen_, newly_closed_);
}
void LoopCloser::archive(ByteWriter& a) { archive_fields(a); }
void LoopCloser::archive(ByteReader& a) {
  archive_fields(a);
  a.check(is_sound(), "closures of submaps that are not there");
}

/// Whether every submap that is spoken of is there; for what comes from a file.
bool LoopCloser::is_sound() const {
  const auto exists = [this](std::size_t submap) { return submap < entries_.size(); };
  const auto both_exist = [&](const auto& pair) {
    return exists(pair.first) && exists(pair.second);
  };
  const auto fits = [&](const auto& seen) {
    // Of a submap that was dropped the surfaces are gone.
    if (!both_exist(seen.first)) return false;
    const Entry& newer = entries_[seen.first.first];
    return newer.dropped || seen.second.size() == newer.submap.surfaces.size();
  };
  std::vector<double> travelled_m;
  for (const Entry& entry : entries_) travelled_m.push_back(entry.travelled_m);
  return only_grows(travelled_m) && std::ranges::all_of(standing_, both_exist) &&
         std::ranges::all_of(tried_, [&](const auto& tried) { return both_exist(tried.first); }) &&
         std::ranges::all_of(tried_places_, both_exist) && std::ranges::all_of(seen_, fits) &&
         std::ranges::all_of(newly_closed_, exists) &&
         std::ranges::all_of(entries_, [&](const Entry& entry) {
           return std::ranges::all_of(entry.closed_with, exists);
         });
}

bool LoopCloser::submaps_lie_within(double reach_m) const {
  return std::ranges::all_of(entries_,
                             [&](const Entry& entry) { return entry.submap.lies_within(reach_m); });
}

std::size_t LoopCloser::submap_count() const { return entries_.size(); }

void LoopCloser::add(FinishedSubmap submap, double travelled_m) {
  Entry entry{.submap = std::move(submap.submap),
              .piece = submap.piece,
              .travelled_m = travelled_m,
              .centre = Eigen::Vector2d::Zero(),
              .radius_m = 0.0,
              .closed_with = {},
              .looks = {},
              .dropped = false};
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
  const auto before = std::exchange(standing_, {});
  for (Entry& entry : entries_) entry.closed_with.clear();
  for (const auto& closure : closures) {
    if (!closure.accepted) continue;
    standing_.emplace(closure.to_submap, closure.from_submap);
    entries_[closure.from_submap].closed_with.push_back(closure.to_submap);
    entries_[closure.to_submap].closed_with.push_back(closure.from_submap);
    if (!before.contains({closure.to_submap, closure.from_submap}))
      newly_closed_.insert(closure.to_submap);
  }
}

/// Shortest travel from a submap to each other: Dijkstra, neighbours in sequence by the path between them, closures at a fixed
/// price. Infinite beyond what makes a difference.
std::vector<double> LoopCloser::travel_from(std::size_t from) const {
  const double enough_m =
      options_.places_max > 0
          ? std::numeric_limits<double>::infinity()
          : std::max(options_.max_half_xy_m / std::max(options_.drift_per_m, 1e-9),
                     kMaxHalfYawRad / std::max(options_.drift_rad_per_m, 1e-9));
  std::vector<double> travel(entries_.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  const auto reach = [&](std::size_t at, double cost) {
    if (cost >= travel[at] || cost > enough_m) return;
    travel[at] = cost;
    open.push({cost, at});
  };
  reach(from, 0.0);
  while (!open.empty()) {
    const auto [cost, at] = open.top();
    open.pop();
    if (cost > travel[at]) continue;
    const double here_m = entries_[at].travelled_m;
    if (at > 0) reach(at - 1, cost + here_m - entries_[at - 1].travelled_m);
    if (at + 1 < entries_.size()) reach(at + 1, cost + entries_[at + 1].travelled_m - here_m);
    for (const std::size_t other : entries_[at].closed_with) reach(other, cost + kClosureTravelM);
  }
  return travel;
}

std::vector<LoopCloser::Pair> LoopCloser::candidates_for(std::size_t newer,
                                                         std::span<const Pose2> map_T_submap) {
  std::vector<Pair> pairs;
  std::vector<Pair> far;
  const Entry& query = entries_[newer];
  if (query.dropped) return pairs;
  const Pose2 map_T_newer = map_T_submap[newer];
  const Eigen::Vector2d centre = map_T_newer * query.centre;
  const auto travel = travel_from(newer);
  for (std::size_t older = 0; older < newer; ++older) {
    const Entry& target = entries_[older];
    if (target.dropped || standing_.contains({newer, older})) continue;
    if (older + kNeighbours >= newer && target.piece == query.piece) continue;
    const Pose2 map_T_older = map_T_submap[older];
    Pair pair{.older = older,
              .newer = newer,
              .older_T_newer = map_T_older.inverse() * map_T_newer,
              .half_xy_m =
                  std::min(kRestM + options_.drift_per_m * travel[older], options_.max_half_xy_m),
              .half_yaw_rad =
                  std::min(kRestRad + options_.drift_rad_per_m * travel[older], kMaxHalfYawRad),
              .distance_m = (centre - map_T_older * target.centre).norm()};
    const double uncertain_m = kRestM + options_.drift_per_m * travel[older];
    if (uncertain_m > options_.max_half_xy_m && pair.distance_m <= uncertain_m + kPlaceHalfM)
      far.push_back(pair);
    if (pair.distance_m > 0.7 * (query.radius_m + target.radius_m) + pair.half_xy_m) continue;
    if (was_tried(pair)) continue;
    pairs.push_back(pair);
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
  if (pairs.size() > static_cast<std::size_t>(options_.candidates_max)) {
    pairs.resize(static_cast<std::size_t>(options_.candidates_max));
  }
  if (options_.places_max > 0 && !far.empty()) {
    for (const Pair& place : places_like(newer, far)) {
      const bool near = std::any_of(pairs.begin(), pairs.end(),
                                    [&](const Pair& pair) { return pair.older == place.older; });
      if (!near) pairs.push_back(place);
    }
  }
  return pairs;
}

/// The few that look most like a submap, best first, less those that were tried. Which these are does not depend on poses.
/// \param far  pairs with older submaps whose distance the window can't hold
std::vector<LoopCloser::Pair> LoopCloser::places_like(std::size_t newer,
                                                      std::span<const Pair> far) {
  const auto& looks = looks_of(newer);
  if (looks.empty()) return {};
  std::vector<std::pair<double, Pair>> ranked;
  for (const Pair& pair : far) {
    const auto& others = looks_of(pair.older);
    if (!others.empty()) ranked.emplace_back(place_distance(looks, others), pair);
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto most = static_cast<std::size_t>(options_.places_max);
  double unlike = std::numeric_limits<double>::infinity();
  if (ranked.size() > most) {
    unlike = kUnlike * ranked[ranked.size() / 2].first;
    ranked.erase(ranked.begin() + static_cast<std::ptrdiff_t>(most), ranked.end());
  }
  std::vector<Pair> places;
  for (auto& [distance, pair] : ranked) {
    if (distance > unlike || tried_places_.contains({pair.older, newer})) continue;
    const double yaw = pair.older_T_newer.yaw;
    const Eigen::Vector2d shift =
        entries_[pair.older].centre - Pose2{0.0, 0.0, yaw}.rotation() * entries_[newer].centre;
    pair.older_T_newer = {shift.x(), shift.y(), yaw};
    pair.half_xy_m = kPlaceHalfM;
    pair.half_yaw_rad = kPi;
    pair.place = true;
    places.push_back(pair);
  }
  return places;
}

const std::vector<float>& LoopCloser::looks_of(std::size_t submap) {
  Entry& entry = entries_[submap];
  if (entry.looks.empty()) entry.looks = describe_place(entry.submap.surfaces);
  return entry.looks;
}

bool LoopCloser::was_tried(const Pair& pair) const {
  const auto tried = tried_.find({pair.older, pair.newer});
  if (tried == tried_.end()) return false;
  const Pose2 change = tried->second.inverse() * pair.older_T_newer;
  return std::hypot(change.x, change.y) < kSameTryM && std::abs(change.yaw) < kSameTryRad;
}

std::vector<LoopClosure> LoopCloser::close_newest(std::span<const Pose2> map_T_submap) {
  const std::size_t newest = entries_.size() - 1;
  const std::vector<Pair> pairs = candidates_for(newest, map_T_submap);
  std::vector<LoopClosure> closures;
  std::vector<bool> seen(entries_[newest].submap.surfaces.size());
  for (std::size_t first = 0; first < pairs.size(); first += kBeside) {
    const std::size_t count = std::min(kBeside, pairs.size() - first);
    for (LoopClosure& closure : compare(std::span(pairs).subspan(first, count))) {
      if (closure.accepted) add_to(seen, seen_.at({newest, closure.from_submap}));
      closures.push_back(std::move(closure));
    }
    if (share_of(seen) >= kCovered) break;
  }
  refuse_rivals(closures, map_T_submap);
  return closures;
}

std::vector<LoopClosure> LoopCloser::close_all(std::span<const Pose2> map_T_submap,
                                               const std::function<bool()>& goes_on) {
  std::vector<Pair> pairs;
  for (std::size_t newer = 1; newer < entries_.size(); ++newer) {
    const auto more = candidates_for(newer, map_T_submap);
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  std::vector<LoopClosure> closures;
  for (std::size_t first = 0; first < pairs.size() && (!goes_on || goes_on()); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, pairs.size() - first);
    auto found = compare(std::span(pairs).subspan(first, count));
    std::move(found.begin(), found.end(), std::back_inserter(closures));
  }
  refuse_rivals(closures, map_T_submap);
  return closures;
}

/// A submap can't be at two places. Where one taken for its looks is contradicted by another closure of the same submap, nobody knows
/// which is right.
void LoopCloser::refuse_rivals(std::vector<LoopClosure>& closures,
                               std::span<const Pose2> map_T_submap) const {
  std::vector<std::size_t> refused;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& a = closures[i];
    if (!a.accepted || !tried_for_looks(a)) continue;
    for (const LoopClosure& b : closures) {
      if (!b.accepted || b.to_submap != a.to_submap) continue;
      const double between_m =
          std::abs(entries_[a.from_submap].travelled_m - entries_[b.from_submap].travelled_m);
      const Pose2 apart = (map_T_submap[a.from_submap] * a.from_T_to).inverse() *
                          (map_T_submap[b.from_submap] * b.from_T_to);
      if (std::hypot(apart.x, apart.y) > kElsewhereM + options_.drift_per_m * between_m)
        refused.push_back(i);
    }
  }
  for (const std::size_t i : refused) {
    closures[i].accepted = false;
    closures[i].reason = "ambiguous: another place matches as well";
  }
}

std::vector<LoopClosure> LoopCloser::compare(std::span<const Pair> pairs) {
  for (const Pair& pair : pairs) {
    if (pair.place) {
      tried_places_.emplace(pair.older, pair.newer);
    } else {
      tried_[{pair.older, pair.newer}] = pair.older_T_newer;
    }
  }
  std::vector<std::optional<LoopClosure>> found(pairs.size());
  std::vector<std::vector<bool>> seen(pairs.size());
  parallel_for(pairs.size(), threads_, [&](std::size_t index) {
    const Pair& pair = pairs[index];
    const Entry& target = entries_[pair.older];
    const Entry& query = entries_[pair.newer];
    const auto probe = query.submap.probe(kProbePoints);
    if (probe.empty() || target.submap.surfaces.empty()) return;
    const MaxPyramid pyramid = target.submap.search_pyramid(submap_options_, pair.half_xy_m);
    const SearchWindow window{pair.older_T_newer, pair.half_xy_m, pair.half_yaw_rad};
    const SearchResult best = search_branch_and_bound(
        probe, pyramid, window,
        pair.place ? std::max(options_.min_score, kPlaceScore) : options_.min_score);
    if (!best.found) return;

    LoopClosure closure;
    closure.from = NodeId{static_cast<int>(pair.older)};
    closure.to = NodeId{static_cast<int>(pair.newer)};
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

    seen[index] = seen_by(pyramid, match.target_T_source, query.submap.surfaces);
    closure.overlap = share_of(seen[index]);
    closure.agreement = closure.overlap > 0.0 ? std::min(1.0, match.score / closure.overlap) : 0.0;

    const double min_overlap =
        pair.place ? std::max(options_.min_overlap, kPlaceOverlap) : options_.min_overlap;
    const double min_agreement =
        pair.place ? std::max(options_.min_agreement, kPlaceAgreement) : options_.min_agreement;
    if (match.status == MatchStatus::kTooFewPairs) {
      closure.reason = "refinement found too few pairs";
    } else if (second.found) {
      closure.reason = "ambiguous: another pose scores nearly as well";
    } else if (closure.overlap < min_overlap) {
      closure.reason = "too little overlap";
    } else if (closure.agreement < min_agreement) {
      closure.reason = "surfaces disagree";
    } else {
      closure.accepted = true;
    }
    found[index] = closure;
  });
  std::vector<LoopClosure> closures;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!found[i]) continue;
    if (found[i]->accepted) seen_[{pairs[i].newer, pairs[i].older}] = std::move(seen[i]);
    closures.push_back(std::move(*found[i]));
  }
  return closures;
}

std::vector<std::size_t> LoopCloser::drop_covered() {
  std::vector<std::size_t> dropped;
  for (const std::size_t newer : std::exchange(newly_closed_, {})) {
    if (entries_[newer].dropped) continue;
    std::vector<bool> seen(entries_[newer].submap.surfaces.size());
    for (const std::size_t older : entries_[newer].closed_with) {
      if (older > newer || entries_[older].dropped) continue;
      add_to(seen, seen_.at({newer, older}));
    }
    if (!(share_of(seen) >= kCovered)) continue;
    entries_[newer].submap = {};
    entries_[newer].dropped = true;
    seen_.erase(seen_.lower_bound({newer, 0}), seen_.lower_bound({newer + 1, 0}));
    dropped.push_back(newer);
  }
  return dropped;
}

bool LoopCloser::is_dropped(std::size_t submap) const { return entries_[submap].dropped; }

void LoopCloser::drop_all() {
  for (Entry& entry : entries_) {
    entry.submap = {};
    entry.dropped = true;
  }
  seen_.clear();
}

bool LoopCloser::tried_for_looks(const LoopClosure& closure) const {
  return tried_places_.contains({closure.from_submap, closure.to_submap});
}

RelativePoseEdge LoopCloser::edge_of(const LoopClosure& closure) const {
  return edge_between(closure.from.index, closure.to.index, {closure.from_T_to, closure.covariance},
                      EdgeKind::kLoopClosure);
}

}  // namespace loopstone
