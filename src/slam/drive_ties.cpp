#include "slam/drive_ties.hpp"

#include <algorithm>
#include <utility>

namespace loopstone {

std::vector<SubmapPair> overlapping(const LaidDrive& older, const LaidDrive& newer) {
  const bool is_one = older.submaps.data() == newer.submaps.data();
  std::vector<std::vector<SubmapPair>> by_newer;
  for (std::size_t b = 0; b < newer.submaps.size(); ++b) {
    const SubmapRecord& submap = newer.submaps[b];
    if (submap.surface_count() == 0) continue;
    const Eigen::Vector2d at = newer.map_T_submaps[b] * submap.centre;
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t a = 0; a < older.submaps.size(); ++a) {
      const SubmapRecord& other = older.submaps[a];
      if (other.surface_count() == 0 || (is_one && a + kLoopSurroundings.beside >= b)) continue;
      const double apart_m = (older.map_T_submaps[a] * other.centre - at).norm();
      if (apart_m <= kLoopSurroundings.near_radii * (submap.radius_m + other.radius_m))
        near.emplace_back(apart_m, a);
    }
    if (near.empty()) continue;
    std::ranges::sort(near);
    if (near.size() > kDriveTies.beside_max) near.resize(kDriveTies.beside_max);
    std::vector<SubmapPair>& pairs = by_newer.emplace_back();
    for (const auto& [apart_m, a] : near) pairs.push_back({{b}, {a}});
  }
  const std::size_t asked = std::min(by_newer.size(), kDriveTies.submaps_max);
  std::vector<SubmapPair> overlap;
  for (std::size_t i = 0; i < asked; ++i) {
    const std::vector<SubmapPair>& pairs = by_newer[i * by_newer.size() / asked];
    overlap.insert(overlap.end(), pairs.begin(), pairs.end());
  }
  return overlap;
}

SurfaceFit fit_of(const LaidDrive& older, const LaidDrive& newer,
                  std::span<const SubmapPair> overlap, const SubmapOptions& options,
                  const GridMatchOptions& match, Threads threads) {
  std::vector<SurfaceFit> fits(overlap.size());
  parallel_for(overlap.size(), threads, [&](std::size_t i) {
    const std::size_t a = overlap[i].older.index;
    const std::size_t b = overlap[i].newer.index;
    fits[i] = fit_of(*older.submaps[a].frozen, *newer.submaps[b].frozen,
                     older.map_T_submaps[a].inverse() * newer.map_T_submaps[b], kDriveTies.near_m,
                     options, match);
  });
  SurfaceFit sum;
  for (const SurfaceFit& fit : fits) sum += fit;
  return sum;
}

double scatter_of(const LaidDrive& drive, const SubmapOptions& options,
                  const GridMatchOptions& match, Threads threads) {
  const SurfaceFit fit = fit_of(drive, drive, overlapping(drive, drive), options, match, threads);
  if (fit.on + fit.off < kDriveTies.least_seen) return kDriveTies.usual_off;
  return fit.off / (fit.on + fit.off);
}

bool shows_one_place(const SurfaceFit& fit, double scatter) {
  return fit.on > 0.0 && fit.off <= (scatter + kDriveTies.more_off) * (fit.on + fit.off) &&
         fit.empty <= kDriveTies.most_empty * fit.seen();
}

}  // namespace loopstone
