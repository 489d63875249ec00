#include "slam/surface_patches.hpp"

#include <array>
#include <cstddef>
#include <deque>
#include <iterator>
#include <utility>
#include <vector>

#include "loopstone/grid/block_grid.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "slam/surface_adjustment_numbers.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kSides = 2;

/// The patches that begin in a cell, -1: none yet.
struct PatchCell {
  std::array<int, kSides> patch{-1, -1};
};

struct Sum {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  double weight = 0.0;
  int first_key = -1;
  bool shared = false;  // more than one key scan
  std::size_t sights = 0;
};

struct Assigned {
  int patch;
  PatchSight sight;
};

/// One grid's patches, beside what is in the result already.
class Finder {
 public:
  explicit Finder(double patch_m) : cells_(patch_m) {}

  void add(int key, const PlacedKey& map_T_key, std::span<const SurfacePoint> points,
           double shift_m) {
    for (const SurfacePoint& point : points) {
      const Eigen::Vector2d position = map_T_key * point.position;
      const Eigen::Vector2d normal = map_T_key.rotation * point.normal.cast<double>();
      PatchCell& cell = cells_.at(cells_.cell_of(position.x() + shift_m, position.y() + shift_m));
      const int patch = patch_of(cell, normal);
      if (patch < 0) continue;
      Sum& sum = sums_[static_cast<std::size_t>(patch)];
      const double weight = point.weight;
      sum.position += weight * position;
      sum.normal += weight * normal;
      sum.weight += weight;
      if (sum.first_key < 0) sum.first_key = key;
      if (sum.first_key != key) sum.shared = true;
      if (!assigned_.empty() && assigned_.back().patch == patch &&
          assigned_.back().sight.key == key) {
        PatchSight& sight = assigned_.back().sight;
        sight.point += point.weight * point.position;
        sight.weight += point.weight;
      } else {
        assigned_.push_back({patch, {key, point.weight, point.weight * point.position}});
        ++sum.sights;
      }
    }
  }

  [[nodiscard]] std::size_t sights() const { return assigned_.size(); }

  void append_to(SurfacePatches& result) const {
    std::vector<std::size_t> next(sums_.size());
    std::size_t end = result.sights.size();
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const Sum& sum = sums_[i];
      const double length = sum.normal.norm();
      if (!sum.shared || !(length > 0.0)) {
        next[i] = kNone;
        continue;
      }
      next[i] = end;
      result.patches.push_back(
          {sum.position / sum.weight, sum.normal / length, end, end + sum.sights});
      end += sum.sights;
    }
    result.sights.resize(end);
    for (const Assigned& assigned : assigned_) {
      std::size_t& place = next[static_cast<std::size_t>(assigned.patch)];
      if (place == kNone) continue;
      PatchSight sight = assigned.sight;
      sight.point /= sight.weight;
      result.sights[place++] = sight;
    }
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  int patch_of(PatchCell& cell, const Eigen::Vector2d& normal) {
    for (int& patch : cell.patch) {
      if (patch < 0) {
        patch = static_cast<int>(sums_.size());
        sums_.emplace_back();
        return patch;
      }
      const Sum& sum = sums_[static_cast<std::size_t>(patch)];
      if (sum.normal.dot(normal) > kSameSurfaceCosine * sum.normal.norm()) return patch;
    }
    return -1;
  }

  BlockGrid<PatchCell> cells_;
  std::vector<Sum> sums_{};
  std::deque<Assigned> assigned_{};  // many: a vector that grows would hold twice as much
};

}  // namespace

std::vector<PlacedKey> placed(std::span<const Pose2> map_T_key) {
  std::vector<PlacedKey> result;
  result.reserve(map_T_key.size());
  for (const Pose2& pose : map_T_key) result.push_back({pose.rotation(), pose.translation()});
  return result;
}

SurfacePatches find_patches(std::span<const PlacedKey> map_T_key,
                            std::span<const std::vector<SurfacePoint>> surfaces, double patch_m,
                            Threads threads) {
  const double shifts_m[] = {0.0, 0.5 * patch_m};
  std::vector<Finder> finders(std::size(shifts_m), Finder(patch_m));
  parallel_for(finders.size(), threads, [&](std::size_t i) {
    for (std::size_t key = 0; key < map_T_key.size(); ++key) {
      finders[i].add(static_cast<int>(key), map_T_key[key], surfaces[key], shifts_m[i]);
    }
  });
  SurfacePatches result;
  std::size_t sights = 0;
  for (const Finder& finder : finders) sights += finder.sights();
  result.sights.reserve(sights);
  for (Finder& finder : finders) std::exchange(finder, Finder(patch_m)).append_to(result);
  return result;
}

std::vector<Eigen::Matrix3d> key_hessians(std::span<const PlacedKey> map_T_key,
                                          const SurfacePatches& patches) {
  std::vector<Eigen::Matrix3d> hessians(map_T_key.size(), Eigen::Matrix3d::Zero());
  for (const SharedSurface& patch : patches.patches) {
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      const PatchSight& sight = patches.sights[i];
      const auto key = static_cast<std::size_t>(sight.key);
      const Eigen::Vector2d arm = map_T_key[key].rotation * sight.point.cast<double>();
      const double turn = patch.normal.y() * arm.x() - patch.normal.x() * arm.y();
      const Eigen::Vector3d jacobian(patch.normal.x(), patch.normal.y(), turn);
      hessians[key] += sight.weight / kPatchGrids * jacobian * jacobian.transpose();
    }
  }
  return hessians;
}

namespace {

/// Ends each patch after sights that the next one does not go on; what only one sees is dropped.
/// \param goes_on  whether a sight belongs to the one before it in its patch
template <typename GoesOn>
void part_where_sights_end(GoesOn&& goes_on, SurfacePatches& patches) {
  std::vector<SharedSurface> parts;
  for (const SharedSurface& patch : patches.patches) {
    for (std::size_t first = patch.first; first < patch.last;) {
      std::size_t end = first + 1;
      while (end < patch.last && goes_on(patches.sights[end - 1], patches.sights[end])) ++end;
      SharedSurface part = patch;
      part.first = first;
      part.last = end;
      if (end - first > 1) parts.push_back(part);
      first = end;
    }
  }
  patches.patches = std::move(parts);
}

}  // namespace

void part_by_visit(std::span<const Pose2> map_T_key, const std::vector<bool>& broken,
                   SurfacePatches& patches) {
  std::vector<double> travelled_m{0.0};
  for (std::size_t i = 1; i < map_T_key.size(); ++i) {
    const double step_m = (map_T_key[i].translation() - map_T_key[i - 1].translation()).norm();
    const bool ends = !broken.empty() && broken[i];
    travelled_m.push_back(travelled_m.back() + step_m +
                          (ends ? 2.0 * kSurfaceAdjustment.visit_gap_m : 0.0));
  }
  const auto travelled_at = [&](const PatchSight& sight) {
    return travelled_m[static_cast<std::size_t>(sight.key)];
  };
  const auto goes_on = [&](const PatchSight& before, const PatchSight& sight) {
    return travelled_at(sight) - travelled_at(before) <= kSurfaceAdjustment.visit_gap_m;
  };
  part_where_sights_end(goes_on, patches);
}

void part_by(std::span<const int> part_of_key, SurfacePatches& patches) {
  const auto part_of = [&](const PatchSight& sight) {
    return part_of_key[static_cast<std::size_t>(sight.key)];
  };
  for (const SharedSurface& patch : patches.patches) {
    const std::span<PatchSight> sights =
        std::span(patches.sights).subspan(patch.first, patch.last - patch.first);
    std::ranges::stable_sort(sights, {}, part_of);
  }
  const auto is_same = [&](const PatchSight& before, const PatchSight& sight) {
    return part_of(sight) == part_of(before);
  };
  part_where_sights_end(is_same, patches);
}

}  // namespace loopstone
