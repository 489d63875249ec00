#include "slam/loop_surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/pairwise_consistency.hpp"

namespace loopstone {

namespace {

Eigen::Vector2d middle_of(std::size_t bin) {
  const double angle = (static_cast<double>(bin) + 0.5) / SurfaceWitness::kBins * kPi;
  return {std::cos(angle), std::sin(angle)};
}

std::size_t bin_of(const Eigen::Vector2d& direction) {
  double angle = std::atan2(direction.y(), direction.x());
  if (angle < 0.0) angle += kPi;
  const auto bin = static_cast<std::size_t>(angle / kPi * SurfaceWitness::kBins);
  return std::min(bin, SurfaceWitness::kBins - 1);
}

/// What a surface falls on: one that faces the same way, beside such a one, or free space.
enum class Laid { kOn, kOff, kEmpty };

Laid where(const LaidSurface& laid) {
  if (!laid.line) return Laid::kEmpty;
  const double off_m = std::abs(laid.line->normal.dot(laid.point - laid.line->point));
  return off_m <= kLoopSurroundings.on_surface_m ? Laid::kOn : Laid::kOff;
}

double weight_of(const SurfacePoint& surface) {
  return std::min(1.0, static_cast<double>(surface.weight));
}

/// \param to_map  turns directions of the target's frame into the map's
SurfaceWitness told_by(const FrozenSubmap& source, const SubmapGrids& target,
                       const Pose2& target_T_source, const Eigen::Matrix2d& to_map) {
  SurfaceWitness told;
  lay_on(source.surfaces, target, target_T_source, [&](const LaidSurface& laid) {
    const std::size_t bin = bin_of(to_map * laid.normal);
    const double weight = weight_of(source.surfaces[laid.index]);
    told.seen[bin] += weight;
    if (where(laid) == Laid::kOn) told.matched[bin] += weight;
  });
  return told;
}

SurfaceFit fit_on(const FrozenSubmap& source, const SubmapGrids& target,
                  const Pose2& target_T_source, double near_m) {
  SurfaceFit fit;
  lay_on(source.surfaces, target, target_T_source, [&](const LaidSurface& laid) {
    const SurfacePoint& surface = source.surfaces[laid.index];
    if (surface.position.norm() > near_m) return;
    const Laid at = where(laid);
    double& sum = at == Laid::kOn ? fit.on : at == Laid::kOff ? fit.off : fit.empty;
    sum += weight_of(surface);
  });
  return fit;
}

/// The best pose near one that the path and a closure foretell.
Pose2 settled(const FrozenSubmap& source, const SubmapTarget& target, const Pose2& foretold,
              const GridMatchOptions& options) {
  const SearchWindow window{foretold, kLoopSurroundings.slack_m, kLoopSurroundings.slack_rad};
  const SubmapGrids grids = target.grids();
  const SearchResult best = search_branch_and_bound(source.probe(kLoopSurroundings.probe_points),
                                                    grids.cells, window, -1.0);
  const Pose2 start = best.found ? best.target_T_source : foretold;
  const MatchResult fine = match_to_grid(source.surfaces, grids.surfaces, start, {}, options, 0);
  return fine.status == MatchStatus::kTooFewPairs ? start : fine.target_T_source;
}

}  // namespace

SurfaceFit& SurfaceFit::operator+=(const SurfaceFit& other) {
  on += other.on;
  off += other.off;
  empty += other.empty;
  return *this;
}

SurfaceFit& SurfaceFit::operator*=(double factor) {
  on *= factor;
  off *= factor;
  empty *= factor;
  return *this;
}

void SurfaceWitness::add(const SurfaceWitness& other) {
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen[bin] += other.seen[bin];
    matched[bin] += other.matched[bin];
  }
}

SurfaceFit fit_of(const FrozenSubmap& older, const FrozenSubmap& newer, const Pose2& older_T_newer,
                  double near_m, const SubmapOptions& options, const GridMatchOptions& match) {
  return fit_of(older, SubmapTarget(older, options, kLoopSurroundings.slack_m), newer,
                SubmapTarget(newer, options, 0.0), older_T_newer, near_m, match);
}

SurfaceFit fit_of(const FrozenSubmap& older, const SubmapTarget& on_older,
                  const FrozenSubmap& newer, const SubmapTarget& on_newer,
                  const Pose2& older_T_newer, double near_m, const GridMatchOptions& match) {
  const Pose2 pose = settled(newer, on_older, older_T_newer, match);
  SurfaceFit fit = fit_on(newer, on_older.grids(), pose, near_m);
  fit += fit_on(older, on_newer.grids(), pose.inverse(), near_m);
  return fit;
}

double agreement_of(const FrozenSubmap& older, const SubmapGrids& on_older,
                    const FrozenSubmap& newer, const Pose2& older_T_newer,
                    const SubmapOptions& options) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const auto agrees = [&](const FrozenSubmap& source, const SubmapGrids& target,
                          const Pose2& target_T_source) {
    const SurfaceFit fit = fit_on(source, target, target_T_source, kAll);
    return fit.share();
  };
  return std::min(
      agrees(newer, on_older, older_T_newer),
      agrees(older, SubmapTarget(newer, options, 0.0).grids(), older_T_newer.inverse()));
}

double agreement_of(const FrozenSubmap& older, const FrozenSubmap& newer,
                    const Pose2& older_T_newer, const SubmapOptions& options) {
  return agreement_of(older, SubmapTarget(older, options, 0.0).grids(), newer, older_T_newer,
                      options);
}

double facing(const std::array<double, SurfaceWitness::kBins>& surfaces,
              const Eigen::Vector2d& direction) {
  double sum = 0.0;
  for (std::size_t bin = 0; bin < SurfaceWitness::kBins; ++bin) {
    if (std::abs(middle_of(bin).dot(direction)) > 0.5 * direction.norm()) sum += surfaces[bin];
  }
  return sum;
}

SurfaceWitness surroundings_of(const LoopClosure& closure, std::span<const SubmapRecord> submaps,
                               const SubmapOptions& options, const GridMatchOptions& match) {
  const Pose2 map_move = map_move_of(closure, submaps);
  const auto around = [&](std::size_t index, SubmapId end) {
    const SubmapRecord& submap = submaps[index];
    return submap.surface_count() > 0 && submap.piece == submaps[end.index].piece;
  };
  const auto first = [](SubmapId end) {
    return end.index - std::min(end.index, kLoopSurroundings.reach);
  };
  const auto last = [&](SubmapId end) {
    return std::min(end.index + kLoopSurroundings.reach + 1, submaps.size());
  };
  SurfaceWitness sum;
  for (std::size_t a = first(closure.from_submap); a < last(closure.from_submap); ++a) {
    if (!around(a, closure.from_submap)) continue;
    const SubmapRecord& older = submaps[a];
    std::optional<SubmapTarget> on_older;
    const std::size_t begin = std::max(first(closure.to_submap), a + kLoopSurroundings.beside + 1);
    for (std::size_t b = begin; b < last(closure.to_submap); ++b) {
      if (!around(b, closure.to_submap)) continue;
      const SubmapRecord& newer = submaps[b];
      const Pose2 map_T_newer = map_move * newer.map_T_submap;
      const Eigen::Vector2d apart = map_T_newer * newer.centre - older.map_T_submap * older.centre;
      if (apart.norm() > kLoopSurroundings.near_radii * (older.radius_m + newer.radius_m)) continue;
      if (!on_older) on_older.emplace(*older.frozen, options, kLoopSurroundings.slack_m);
      const Pose2 pose =
          settled(*newer.frozen, *on_older, older.map_T_submap.inverse() * map_T_newer, match);
      sum.add(told_by(*newer.frozen, on_older->grids(), pose, older.map_T_submap.rotation()));
      sum.add(told_by(*older.frozen, SubmapTarget(*newer.frozen, options, 0.0).grids(),
                      pose.inverse(), map_T_newer.rotation()));
    }
  }
  return sum;
}

bool hold(const SurfaceWitness& surroundings, const Eigen::Vector2d& map_pull, double harmless_m) {
  for (std::size_t bin = 0; bin < SurfaceWitness::kBins; ++bin) {
    const Eigen::Vector2d direction = middle_of(bin);
    if (std::abs(direction.dot(map_pull)) <= harmless_m) continue;
    const double matched = facing(surroundings.matched, direction);
    if (matched < kLoopSurroundings.least_surfaces ||
        matched < kLoopSurroundings.least_share * facing(surroundings.seen, direction))
      return false;
  }
  return true;
}

}  // namespace loopstone
