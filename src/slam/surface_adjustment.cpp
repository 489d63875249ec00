#include "loopstone/slam/surface_adjustment.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/graph/block_system.hpp"
#include "loopstone/graph/linearised_graph.hpp"
#include "slam/open_directions.hpp"
#include "slam/scan_edges.hpp"
#include "slam/surface_adjustment_numbers.hpp"
#include "slam/surface_patches.hpp"
#include "slam/surface_segments.hpp"
#include "slam/surface_system.hpp"
#include "slam/tied_parts.hpp"

namespace loopstone {

namespace {

using Blocks = std::vector<Eigen::Vector3d>;

double dot(const Blocks& a, const Blocks& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

class Adjustment {
 public:
  Adjustment(const PoseGraph& graph, std::span<const std::vector<SurfacePoint>> surfaces,
             const SurfaceAdjustmentOptions& options, Threads threads, const PathWeakness& weakness)
      : graph_(graph),
        surfaces_(surfaces),
        options_(options),
        threads_(threads),
        weakness_(weakness),
        // Closures are softened as the back end does.
        equations_(graph, RobustKernel::kHuber, kClosureHuberWidth),
        solver_(equations_.hessian()),
        state_{graph.poses, graph.landmarks} {
    for (int i = 0; i < static_cast<int>(graph.poses.size()); ++i) {
      places_.push_back(equations_.place_of(NodeId{i}));
    }
    const std::size_t size = equations_.gradient().size();
    for (Blocks* blocks : {&step_, &residual_, &direction_, &product_, &conditioned_}) {
      blocks->resize(size);
    }
  }

  SurfaceAdjustment run() {
    for (int round = 0; round < options_.rounds && !step_.empty(); ++round) {
      if (!improve()) break;
    }
    know_poses();
    result_.poses = std::move(state_.poses);
    result_.landmarks = std::move(state_.landmarks);
    return std::move(result_);
  }

 private:
  /// One Gauss-Newton step with patches found at the present poses. False when nothing is left to
  /// gain.
  bool improve() {
    const auto keys = placed(state_.poses);
    const SurfacePatches patches = find_patches(keys, surfaces_, options_.patch_m, threads_);
    if (patches.patches.empty()) return false;
    SurfaceSystem system(patches, places_, step_.size(), threads_);
    const double spread_m = system.spread_m(keys);
    if (result_.rounds == 0) result_.spread_before_m = result_.spread_after_m = spread_m;
    equations_.linearise(state_);
    system.linearise(keys, kSurfaceAdjustment.shared_noise *
                               std::max(spread_m, kSurfaceAdjustment.least_sigma_m));
    if (!segments_ && !factorise(system)) return false;
    find_step(system);
    GraphState trial = equations_.moved(state_, step_);
    const double spread_after_m = system.spread_m(placed(trial.poses));
    if (!(spread_after_m <= spread_m)) return false;
    state_ = std::move(trial);
    result_.spread_after_m = spread_after_m;
    ++result_.rounds;
    return true;
  }

  /// How well the poses that were found are known: by all, and by the path alone.
  void know_poses() {
    graph_.poses = state_.poses;
    graph_.landmarks = state_.landmarks;
    result_.covariances = PoseCovariances(graph_, nullptr, weakness_.broken);
    if (step_.empty()) return;
    const auto keys = placed(state_.poses);
    SurfacePatches patches = find_patches(keys, surfaces_, options_.patch_m, threads_);
    // What lies beside one another by chance, where nothing ties both sides of a break, is no
    // evidence.
    const TieBounds bounds{options_.patch_m, kSurfaceAdjustment.tied_rad};
    const std::vector<int> part_of_key = tied_parts(graph_, weakness_.broken, bounds);
    if (patches.patches.empty()) return;
    const double spread_m =
        std::max(SurfaceSystem(patches, places_, step_.size(), threads_).spread_m(keys),
                 kSurfaceAdjustment.least_sigma_m);
    forget_open_directions(keys, weakness_.open, patches);
    part_by(part_of_key, patches);
    {
      SurfaceSystem system(patches, places_, step_.size(), threads_, SurfaceUse::kHold);
      system.linearise(keys, kSurfaceAdjustment.believed_noise * spread_m);
      result_.covariances = PoseCovariances(graph_, &system, weakness_.broken);
    }
    part_by_visit(state_.poses, untied_breaks(graph_, weakness_.broken, bounds), patches);
    SurfaceSystem by_visit(patches, places_, step_.size(), threads_, SurfaceUse::kHold);
    by_visit.linearise(keys, kSurfaceAdjustment.holding_noise * spread_m);
    result_.path = PathSurfaces(state_.poses, places_, step_.size(), weakness_, by_visit);
  }

  /// The preconditioner: poses hardly change, so that of the first round serves all.
  bool factorise(const SurfaceSystem& system) {
    BlockMatrix matrix = equations_.hessian();
    for (std::size_t i = 0; i < matrix.diagonal.size(); ++i) {
      matrix.diagonal[i] += kSurfaceAdjustment.own_surfaces * system.diagonal()[i];
    }
    segments_.emplace(state_.poses, places_, step_.size());
    return solver_.factorise(matrix) && segments_->factorise(system, equations_.hessian());
  }

  /// Preconditioned conjugate gradients: Saad 2003, "Iterative methods for sparse linear systems",
  /// algorithm 9.1.
  void find_step(SurfaceSystem& system) {
    for (std::size_t i = 0; i < step_.size(); ++i) {
      residual_[i] = -(equations_.gradient()[i] + system.gradient()[i]);
      step_[i].setZero();
    }
    condition_residual();
    direction_ = conditioned_;
    double left = dot(residual_, conditioned_);
    const double enough =
        kSurfaceAdjustment.step_accuracy * kSurfaceAdjustment.step_accuracy * left;
    for (int i = 0; i < kSurfaceAdjustment.products_max && left > enough; ++i) {
      multiply(equations_.hessian(), direction_, product_);
      system.multiply_add(direction_, product_);
      ++result_.products;
      const double length = left / dot(direction_, product_);
      for (std::size_t k = 0; k < step_.size(); ++k) {
        step_[k] += length * direction_[k];
        residual_[k] -= length * product_[k];
      }
      condition_residual();
      const double next = dot(residual_, conditioned_);
      const double kept = next / left;
      left = next;
      for (std::size_t k = 0; k < step_.size(); ++k) {
        direction_[k] = conditioned_[k] + kept * direction_[k];
      }
    }
  }

  void condition_residual() {
    conditioned_ = residual_;
    solver_.solve_in_place(conditioned_);
    segments_->add_correction(residual_, conditioned_);
  }

  PoseGraph graph_;
  std::span<const std::vector<SurfacePoint>> surfaces_;
  const SurfaceAdjustmentOptions& options_;
  Threads threads_;
  const PathWeakness& weakness_;
  LinearisedGraph equations_;
  BlockSolver solver_;
  std::optional<SurfaceSegments> segments_{};
  GraphState state_;
  std::vector<int> places_{};
  Blocks step_{};
  Blocks residual_{};
  Blocks direction_{};
  Blocks product_{};
  Blocks conditioned_{};
  SurfaceAdjustment result_{};
};

}  // namespace

SurfaceAdjustment adjust_to_surfaces(const PoseGraph& graph,
                                     std::span<const std::vector<SurfacePoint>> surfaces,
                                     const SurfaceAdjustmentOptions& options, Threads threads,
                                     const PathWeakness& weakness) {
  if (surfaces.size() != graph.poses.size()) {
    throw UsageError("surface adjustment: " + std::to_string(surfaces.size()) + " scans for " +
                     std::to_string(graph.poses.size()) + " poses; each pose needs its own");
  }
  for (const std::vector<bool>* flags : {&weakness.broken, &weakness.open}) {
    if (flags->empty() || flags->size() == graph.poses.size()) continue;
    throw UsageError("surface adjustment: weaknesses of " + std::to_string(flags->size()) +
                     " poses for " + std::to_string(graph.poses.size()) +
                     "; give them for each pose or for none");
  }
  return Adjustment(graph, surfaces, options, threads, weakness).run();
}

}  // namespace loopstone
