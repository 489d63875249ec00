#include "slam/surface_system.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/median.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "registration/open_translation.hpp"
#include "slam/surface_adjustment_numbers.hpp"

namespace loopstone {

namespace {

/// So many shares that are summed in order, whatever the number of threads.
constexpr std::size_t kChunks = 8;

/// The straight line distance = offset + slope * along through weighted points.
struct Line {
  double offset = 0.0;
  double slope = 0.0;
  double a = 0.0;  ///< C^-1, row by row
  double b = 0.0;
  double c = 0.0;
};

/// A sight beside its patch: how far off along the normal, where along it, and how the distance
/// grows with yaw.
struct Offset {
  double distance;
  double along;
  double turn;
};

Offset offset_of(const PatchSight& sight, const SharedSurface& patch,
                 std::span<const PlacedKey> map_T_key) {
  const PlacedKey& key = map_T_key[static_cast<std::size_t>(sight.key)];
  const Eigen::Vector2d arm = key.rotation * sight.point.cast<double>();
  const Eigen::Vector2d offset = key.translation + arm - patch.centre;
  const Eigen::Vector2d tangent(-patch.normal.y(), patch.normal.x());
  return {patch.normal.dot(offset), tangent.dot(offset),
          patch.normal.y() * arm.x() - patch.normal.x() * arm.y()};
}

struct LineSums {
  /// \param slope_sigma  how far the line may be turned
  explicit LineSums(double slope_sigma) : wtt(1.0 / (slope_sigma * slope_sigma)) {}

  double w = 0.0;
  double wt = 0.0;
  double wtt;
  double wr = 0.0;
  double wtr = 0.0;

  void add(double weight, double along, double distance) {
    w += weight;
    wt += weight * along;
    wtt += weight * along * along;
    wr += weight * distance;
    wtr += weight * along * distance;
  }
  [[nodiscard]] Line line() const {
    const double scale = 1.0 / (w * wtt - wt * wt);
    Line result{.a = wtt * scale, .b = -wt * scale, .c = w * scale};
    result.offset = result.a * wr + result.b * wtr;
    result.slope = result.b * wr + result.c * wtr;
    return result;
  }
};

}  // namespace

SurfaceSystem::SurfaceSystem(const SurfacePatches& patches, std::span<const int> places,
                             std::size_t size, Threads threads, SurfaceUse use)
    : patches_(patches),
      places_(places),
      threads_(threads),
      use_(use),
      rows_(patches.sights.size()),
      open_(size),
      inverses_(patches.patches.size()),
      chunks_(kChunks),
      gradient_(size),
      diagonal_(size) {
  std::size_t patch = 0;
  for (std::size_t i = 0; i < kChunks; ++i) {
    chunks_[i].first = patch;
    const std::size_t end = patches.sights.size() * (i + 1) / kChunks;
    while (patch < patches.patches.size() && patches.patches[patch].last <= end) ++patch;
    if (i + 1 == kChunks) patch = patches.patches.size();
    chunks_[i].last = patch;
    chunks_[i].vector.resize(size);
    chunks_[i].diagonal.resize(size);
  }
}

void SurfaceSystem::linearise_patch(std::size_t index, std::span<const PlacedKey> map_T_key,
                                    double sigma_m, Chunk& chunk) {
  const SharedSurface& patch = patches_.patches[index];
  const double information = 1.0 / (kPatchGrids * sigma_m * sigma_m);
  auto& distances = chunk.distances;
  distances.resize(patch.last - patch.first);
  const double slope_sigma =
      use_ == SurfaceUse::kAdjust ? kSurfaceAdjustment.slope_sigma : kSurfaceAdjustment.free_slope;
  LineSums plain(slope_sigma);
  for (std::size_t i = patch.first; i < patch.last; ++i) {
    const PatchSight& sight = patches_.sights[i];
    const Offset offset = offset_of(sight, patch, map_T_key);
    rows_[i] = {places_[static_cast<std::size_t>(sight.key)], static_cast<float>(offset.turn),
                static_cast<float>(offset.along), 0.0F};
    distances[i - patch.first] = offset.distance;
    plain.add(information * sight.weight, rows_[i].along, distances[i - patch.first]);
  }
  Line line = plain.line();
  // Twice: the first line is bent by what does not belong to it.
  for (int round = 0; round < 2; ++round) {
    LineSums sums(slope_sigma);
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      Row& row = rows_[i];
      const double off = distances[i - patch.first] - line.offset - line.slope * row.along;
      const double weight = information * patches_.sights[i].weight *
                            evaluate(RobustKernel::kCauchy, kSurfaceAdjustment.kernel_width,
                                     off * off / (sigma_m * sigma_m))
                                .weight;
      row.weight = static_cast<float>(weight);
      sums.add(row.weight, row.along, distances[i - patch.first]);
    }
    line = sums.line();
  }
  inverses_[index] = {line.a, line.b, line.c};
  for (std::size_t i = patch.first; i < patch.last; ++i) {
    const Row& row = rows_[i];
    const double off = distances[i - patch.first] - line.offset - line.slope * row.along;
    chunk.cost += 0.5 * patches_.sights[i].weight *
                  evaluate(RobustKernel::kCauchy, kSurfaceAdjustment.kernel_width,
                           off * off / (sigma_m * sigma_m))
                      .cost;
    if (row.place < 0) continue;
    const auto place = static_cast<std::size_t>(row.place);
    const Eigen::Vector3d jacobian = this->jacobian(patch.normal, row);
    const double weight = row.weight;
    chunk.vector[place] += weight * off * jacobian;
    const double along = row.along;
    const double own =
        weight - weight * weight * (line.a + 2.0 * line.b * along + line.c * along * along);
    chunk.diagonal[place] += own * jacobian * jacobian.transpose();
  }
}

/// What little walls seem to say along a corridor is noise of their normals. All that pass along
/// it together would pull it longer or shorter by centimetres.
void SurfaceSystem::find_open(std::span<const PlacedKey> map_T_key) {
  const std::vector<Eigen::Matrix3d> hessians = key_hessians(map_T_key, patches_);
  std::fill(open_.begin(), open_.end(), Open{});
  for (std::size_t key = 0; key < hessians.size(); ++key) {
    if (places_[key] < 0) continue;
    const auto open = open_translation(hessians[key]);
    if (open && open->information > 0.0)
      open_[static_cast<std::size_t>(places_[key])] = {open->motion,
                                                       open->along / open->information};
  }
}

double SurfaceSystem::linearise(std::span<const PlacedKey> map_T_key, double sigma_m) {
  if (use_ == SurfaceUse::kAdjust) find_open(map_T_key);
  parallel_for(chunks_.size(), threads_, [&](std::size_t i) {
    Chunk& chunk = chunks_[i];
    chunk.cost = 0.0;
    std::fill(chunk.vector.begin(), chunk.vector.end(), Eigen::Vector3d::Zero());
    std::fill(chunk.diagonal.begin(), chunk.diagonal.end(), Eigen::Matrix3d::Zero());
    for (std::size_t patch = chunk.first; patch < chunk.last; ++patch) {
      linearise_patch(patch, map_T_key, sigma_m, chunk);
    }
  });
  std::fill(gradient_.begin(), gradient_.end(), Eigen::Vector3d::Zero());
  std::fill(diagonal_.begin(), diagonal_.end(), Eigen::Matrix3d::Zero());
  double cost = 0.0;
  for (const Chunk& chunk : chunks_) {
    cost += chunk.cost;
    for (std::size_t i = 0; i < gradient_.size(); ++i) {
      gradient_[i] += chunk.vector[i];
      diagonal_[i] += chunk.diagonal[i];
    }
  }
  return cost;
}

void SurfaceSystem::multiply_add(std::span<const Eigen::Vector3d> x, std::span<Eigen::Vector3d> y) {
  parallel_for(chunks_.size(), threads_, [&](std::size_t index) {
    Chunk& chunk = chunks_[index];
    std::fill(chunk.vector.begin(), chunk.vector.end(), Eigen::Vector3d::Zero());
    for (std::size_t p = chunk.first; p < chunk.last; ++p) {
      const SharedSurface& patch = patches_.patches[p];
      chunk.distances.resize(patch.last - patch.first);
      double* const moved = chunk.distances.data();
      double u = 0.0;
      double v = 0.0;
      for (std::size_t i = patch.first; i < patch.last; ++i) {
        const Row& row = rows_[i];
        double off = 0.0;
        if (row.place >= 0) {
          const Eigen::Vector3d& step = x[static_cast<std::size_t>(row.place)];
          off = jacobian(patch.normal, row).dot(step);
        }
        moved[i - patch.first] = off;
        u += row.weight * off;
        v += row.weight * row.along * off;
      }
      const Inverse& inverse = inverses_[p];
      const double offset = inverse.a * u + inverse.b * v;
      const double slope = inverse.b * u + inverse.c * v;
      for (std::size_t i = patch.first; i < patch.last; ++i) {
        const Row& row = rows_[i];
        if (row.place < 0) continue;
        const double pull = row.weight * (moved[i - patch.first] - offset - slope * row.along);
        chunk.vector[static_cast<std::size_t>(row.place)] += pull * jacobian(patch.normal, row);
      }
    }
  });
  for (const Chunk& chunk : chunks_) {
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += chunk.vector[i];
  }
}

double SurfaceSystem::spread_m(std::span<const PlacedKey> map_T_key) const {
  std::vector<float> off(patches_.sights.size());
  parallel_for(chunks_.size(), threads_, [&](std::size_t chunk) {
    std::vector<Offset> offsets;
    for (std::size_t p = chunks_[chunk].first; p < chunks_[chunk].last; ++p) {
      const SharedSurface& patch = patches_.patches[p];
      offsets.clear();
      LineSums sums(kSurfaceAdjustment.slope_sigma);
      for (std::size_t i = patch.first; i < patch.last; ++i) {
        const PatchSight& sight = patches_.sights[i];
        offsets.push_back(offset_of(sight, patch, map_T_key));
        // Any scale of information: only the slope's prior, of a few millimetres, depends on it.
        sums.add(sight.weight * 1e4, offsets.back().along, offsets.back().distance);
      }
      const Line line = sums.line();
      for (std::size_t i = 0; i < offsets.size(); ++i) {
        off[patch.first + i] = static_cast<float>(
            std::abs(offsets[i].distance - line.offset - line.slope * offsets[i].along));
      }
    }
  });
  return kSigmaPerMedian * static_cast<double>(median_of(off));
}

}  // namespace loopstone
