#include "loopstone/registration/map_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/pose_distance.hpp"
#include "registration/map_lattice_search.hpp"

namespace loopstone {

namespace {

/// Lattice poses that score so much less than the best are not refined: off the lattice, a pose
/// gains less than that.
constexpr double kMargin = 0.12;
constexpr std::size_t kRefinePoints = 400;
/// The best of them are started again from around where they came to rest.
constexpr std::size_t kPolished = 4;
constexpr double kPolishM = 0.1;
/// A point is on a wall within this (standard deviation of a Gaussian) ...
constexpr double kOnWallM = 0.04;
/// ... and hidden when its beam comes so near to a wall ...
constexpr double kBlockedM = 0.05;
/// ... that is so far in front of it.
constexpr double kInFrontM = 0.35;

using Points = std::vector<Eigen::Vector2d>;

/// Points at an even spacing along the surfaces: a beam's share of a scan is larger the nearer the
/// surface is.
Points evenly_spaced(std::span<const Eigen::Vector2d> points, double spacing_m) {
  Points kept;
  for (const auto& point : points) {
    if (kept.empty() || (point - kept.back()).norm() >= spacing_m) kept.push_back(point);
  }
  return kept;
}

/// The order in which any first few are spread over all: indexes by their bits reversed.
Points spread(const Points& points) {
  unsigned bits = 0;
  while ((std::size_t{1} << bits) < points.size()) ++bits;
  Points ordered;
  ordered.reserve(points.size());
  for (std::size_t i = 0; i < std::size_t{1} << bits; ++i) {
    std::size_t reversed = 0;
    for (unsigned bit = 0; bit < bits; ++bit) reversed |= ((i >> bit) & 1U) << (bits - 1 - bit);
    if (reversed < points.size()) ordered.push_back(points[reversed]);
  }
  return ordered;
}

Points search_points(std::span<const Eigen::Vector2d> source, const MapMatchOptions& options) {
  Points near;
  for (const auto& point : source) {
    if (point.norm() <= options.range_max_m) near.push_back(point);
  }
  const bool enough = 2 * near.size() >= source.size();
  Points spaced = evenly_spaced(enough ? std::span<const Eigen::Vector2d>(near) : source, 0.1);
  return spread(thinned(spaced, static_cast<std::size_t>(options.points_max)));
}

bool same_place(const Pose2& a, const Pose2& b, const MapMatchOptions& options) {
  return is_within(a, b, options.distinct_m, options.distinct_rad);
}

/// Does the way from the laser to the point lead past every wall? Steps as far as the nearest wall
/// is away.
/// Source: Hart 1996, "Sphere tracing".
bool is_clear(const MapField& field, const Eigen::Vector2d& laser, const Eigen::Vector2d& point) {
  const Grid<float>& distances = field.distances();
  const GridFrame& frame = distances.frame();
  const double length = (point - laser).norm();
  if (length <= kInFrontM) return true;
  const Eigen::Vector2d direction = (point - laser) / length;
  const double step_min = 0.5 * frame.resolution;
  for (double range = kInFrontM; range < length - kInFrontM;) {
    const Cell cell = frame.cell_of(laser + range * direction);
    if (!frame.contains(cell)) return true;
    const auto distance = static_cast<double>(distances[cell]);
    if (distance < kBlockedM * 0.5) return false;
    range += std::max(distance - frame.resolution, step_min);
  }
  return true;
}

/// Is the wall that the point lies on seen from its other side, so that what lies in front of the
/// point is the wall itself? A thin wall's two faces look alike but for that. Looks along the
/// normal, as a beam may graze the wall.
bool is_behind_wall(const MapField& field, const Eigen::Vector2d& laser,
                    const Eigen::Vector2d& point, const Eigen::Vector2d& gradient) {
  constexpr double kClearGradient = 0.3;  // in the middle of a wall's cell there is none
  const double steepness = gradient.norm();
  if (steepness < kClearGradient) return false;
  Eigen::Vector2d normal = gradient / steepness;
  if (normal.dot(laser - point) < 0.0) normal = -normal;
  const Grid<float>& distances = field.distances();
  const double cell_m = distances.frame().resolution;
  // Beyond the face's own cell, wherever in it the face is.
  for (const double cells : {1.2, 2.2, 3.2}) {
    const Cell cell = distances.frame().cell_of(point + cells * cell_m * normal);
    if (distances.frame().contains(cell) && static_cast<double>(distances[cell]) < 0.5 * cell_m) {
      return true;
    }
  }
  return false;
}

/// Share of the points that are on a wall and in sight of the laser.
/// \param free_m  so far from a wall costs nothing
double explained_share(std::span<const Eigen::Vector2d> source, const MapField& field,
                       const Pose2& map_T_source, double free_m = 0.0) {
  double sum = 0.0;
  for (const auto& point : source) {
    const Eigen::Vector2d on_map = map_T_source * point;
    const FieldSample sample = field.sample(0, on_map);
    const double ratio = std::max(sample.distance_m - free_m, 0.0) / kOnWallM;
    const double on_wall = std::exp(-0.5 * ratio * ratio);
    if (on_wall < 0.05) continue;
    const Eigen::Vector2d laser = map_T_source.translation();
    if (is_behind_wall(field, laser, on_map, sample.gradient) || !is_clear(field, laser, on_map))
      continue;
    sum += on_wall;
  }
  return sum / static_cast<double>(source.size());
}

/// The best of a match and of what is found from other starts: by the share of points explained, or
/// by cost where that is much the same.
MatchResult best_from(const Points& points, const MapField& field, const MatchResult& match,
                      std::span<const Pose2> starts) {
  constexpr double kSameShare = 0.01;
  constexpr double kSamePoseM = 0.01;
  constexpr double kWorthALook = 1.5;
  const auto cost_at = [&](const Pose2& pose) {
    return field_cost(points, field, 0, pose, FieldMatchOptions{}.kernel_width_m).cost;
  };
  MatchResult best = match;
  best.score = explained_share(points, field, best.target_T_source);
  double best_cost = cost_at(best.target_T_source);
  for (const Pose2& start : starts) {
    MatchResult other = match_to_field(points, field, start, {}, 0);
    if (other.status == MatchStatus::kTooFewPairs) continue;
    const double cost = cost_at(other.target_T_source);
    if (cost > kWorthALook * best_cost) continue;
    const bool moved =
        (other.target_T_source.translation() - best.target_T_source.translation()).norm() >
        kSamePoseM;
    other.score = moved || cost < best_cost ? explained_share(points, field, other.target_T_source)
                                            : best.score;
    const double gain = other.score - best.score;
    if (gain < -kSameShare || (gain <= kSameShare && !(cost < best_cost))) continue;
    best = other;
    best_cost = cost;
  }
  return best;
}

/// The lattice is coarse, and between furniture the field has more than one valley: looks all
/// around.
MatchResult polished(const Points& points, const MapField& field, const MatchResult& match) {
  const Pose2& middle = match.target_T_source;
  std::vector<Pose2> starts;
  for (const double x : {-kPolishM, 0.0, kPolishM}) {
    for (const double y : {-kPolishM, 0.0, kPolishM})
      starts.push_back({middle.x + x, middle.y + y, middle.yaw});
  }
  return best_from(points, field, match, starts);
}

/// With every point of the scan, from headings to either side as well: the last hundredths of a
/// degree.
MatchResult finished(const Points& points, const MapField& field, const MatchResult& match) {
  constexpr double kTurnRad = 0.015;
  const Pose2& middle = match.target_T_source;
  const std::array starts{middle, Pose2{middle.x, middle.y, wrap_angle(middle.yaw - kTurnRad)},
                          Pose2{middle.x, middle.y, wrap_angle(middle.yaw + kTurnRad)}};
  MatchResult best = best_from(points, field, match, starts);
  best.score = match.score;
  return best;
}

/// That the best pose explains clearly more than any other one, also where walls are drawn as well
/// as cells can: of two places that are alike one may lie a cell better on them, with all of its
/// walls at once, and a beam or two more may graze a corner.
bool stands_out(const Points& points, const MapField& field, std::span<const MatchResult> poses) {
  constexpr double kClearly = 0.06;
  const double free_m = field.distances().frame().resolution;
  const auto share = [&](const MatchResult& match) {
    return explained_share(points, field, match.target_T_source, free_m);
  };
  const double best = share(poses.front());
  // One whose points are a cell off, all of them, scores so much.
  const double ratio = free_m / kOnWallM;
  const double least = std::exp(-0.5 * ratio * ratio) * (poses.front().score - kClearly);
  return std::ranges::all_of(poses.subspan(1), [&](const MatchResult& other) {
    return other.score < least || best - share(other) > kClearly;
  });
}

}  // namespace

MapMatch match_on_map(std::span<const Eigen::Vector2d> source, const MapSearch& map,
                      const std::optional<SearchWindow>& window, const MapMatchOptions& options) {
  MapMatch result;
  if (source.empty()) return result;
  const Points probe = search_points(source, options);
  const auto lattice = make_map_lattice(probe, map, window);
  const LatticePoses found = search_map_lattice(probe, map, lattice, options.min_score, kMargin);
  result.evaluations = found.evaluations;

  std::vector<Pose2> starts;
  bool all_refined = true;
  for (const LatticePose& candidate : found.poses) {
    const bool known = std::any_of(starts.begin(), starts.end(), [&](const Pose2& start) {
      return same_place(start, candidate.map_T_source, options);
    });
    if (known) continue;
    if (starts.size() == static_cast<std::size_t>(options.refined_max)) {
      all_refined = false;
      break;
    }
    starts.push_back(candidate.map_T_source);
  }

  const Points refine = thinned(source, kRefinePoints);
  std::vector<MatchResult> refined;
  for (const Pose2& start : starts) {
    MatchResult match = match_to_field(refine, map.field(), start, {}, 1);
    if (match.status == MatchStatus::kTooFewPairs) continue;
    match.score = explained_share(refine, map.field(), match.target_T_source);
    refined.push_back(std::move(match));
  }
  const auto by_score = [](const MatchResult& a, const MatchResult& b) {
    return a.score > b.score;
  };
  std::stable_sort(refined.begin(), refined.end(), by_score);
  for (std::size_t i = 0; i < std::min(kPolished, refined.size()); ++i)
    refined[i] = polished(refine, map.field(), refined[i]);
  std::stable_sort(refined.begin(), refined.end(), by_score);
  // Two starts may have led to one pose.
  std::vector<MatchResult> distinct;
  for (MatchResult& match : refined) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const MatchResult& other) {
      return same_place(other.target_T_source, match.target_T_source, options);
    });
    if (!known) distinct.push_back(std::move(match));
  }
  if (!distinct.empty()) {
    const double next = distinct.size() > 1 ? distinct[1].score : 0.0;
    // Along a corridor the next pose found explains as much.
    result.sure = all_refined && distinct[0].score >= options.sure_score &&
                  distinct[0].score - next > options.sure_gap &&
                  stands_out(refine, map.field(), distinct);
  }
  result.complete = all_refined && distinct.size() <= static_cast<std::size_t>(options.poses_max);
  if (distinct.size() > static_cast<std::size_t>(options.poses_max))
    distinct.resize(static_cast<std::size_t>(options.poses_max));
  if (!distinct.empty())
    distinct[0] = finished(Points(source.begin(), source.end()), map.field(), distinct[0]);
  result.poses = std::move(distinct);
  return result;
}

}  // namespace loopstone
