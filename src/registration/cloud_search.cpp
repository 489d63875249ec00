#include "loopstone/registration/cloud_search.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/sensor/point_cloud.hpp"
#include "registration/cloud_search_judge.hpp"
#include "registration/cloud_search_refine.hpp"
#include "registration/cloud_search_sample.hpp"
#include "registration/cloud_search_starts.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMinPoints = 3;

/// Of the field's voxels, as a share of the model's radius.
constexpr double kVoxelShare = 0.035;
constexpr double kMarginShare = 0.3;
constexpr std::size_t kMaxVoxels = std::size_t{1} << 20;

/// The places that each turn is tried at: the most promising ones of those that
/// are laid out.
constexpr std::size_t kPlaces = 2;
/// The rounds of the search: so many steps, then this share of the starts is
/// kept.
constexpr int kFirstSteps = 4;
constexpr int kSecondSteps = 8;
constexpr int kThirdSteps = 10;
constexpr double kKept = 0.25;
constexpr std::size_t kLeastKept = 8;
constexpr std::size_t kMorePoints = 4;  ///< in the third round, times the first's
/// Then so many, all apart, are refined with so many points, first on the
/// field, and if their rmse is within so many times the best one's then,
/// against exact nearest points.
constexpr std::size_t kRefined = 4;
constexpr int kFourthSteps = 10;
constexpr double kHopeful = 1.5;
constexpr std::size_t kFinePoints = 2000;
constexpr double kCoarseProgress = 1e-4;
constexpr double kFineProgress = 1e-5;
/// Poses nearer than this (radians; shares of the model's radius) are the same.
constexpr double kSame = 0.2;

template <int kDimension>
using PointsOf = std::vector<Eigen::Matrix<double, kDimension, 1>>;

template <int kDimension>
PointsOf<kDimension> finite_points(std::span<const Eigen::Matrix<double, kDimension, 1>> points) {
  PointsOf<kDimension> finite;
  finite.reserve(points.size());
  std::copy_if(points.begin(), points.end(), std::back_inserter(finite),
               [](const auto& point) { return is_usable_point(point); });
  return finite;
}

template <int kDimension>
const PointsOf<kDimension>& enough(const PointsOf<kDimension>& finite) {
  if (finite.size() < kMinPoints) {
    throw DataError({}, "the model has fewer than 3 points with finite coordinates");
  }
  return finite;
}

template <int kDimension>
DistanceField<kDimension> field_of_model(
    std::span<const Eigen::Matrix<double, kDimension, 1>> finite,
    const PrincipalFrame<kDimension>& frame) {
  const auto placed = in_frame<kDimension>(finite, frame);
  const double radius_m = frame.radius_m > 0.0 ? frame.radius_m : 1.0;
  return DistanceField<kDimension>(
      placed, voxels_covering<kDimension>(placed, static_cast<float>(kVoxelShare * radius_m),
                                          static_cast<float>(kMarginShare * radius_m), kMaxVoxels));
}

/// The source in its own frame, all of it and a sample.
template <int kDimension>
struct Placed {
  PrincipalFrame<kDimension> frame;
  PointsOf<kDimension> all;
  PointsOf<kDimension> fine;
  std::vector<Eigen::Matrix<float, kDimension, 1>> fine_single;
};

template <int kDimension>
Placed<kDimension> place(std::span<const Eigen::Matrix<double, kDimension, 1>> finite,
                         bool upright) {
  Placed<kDimension> placed{principal_frame<kDimension>(finite, upright), {}, {}, {}};
  const auto single = in_frame<kDimension>(finite, placed.frame);
  placed.all.reserve(finite.size());
  for (const auto& point : finite) {
    placed.all.push_back(placed.frame.rotation * (point - placed.frame.centre));
  }
  for (const std::size_t i : spread_sample<kDimension>(single, kFinePoints)) {
    placed.fine.push_back(placed.all[i]);
    placed.fine_single.push_back(single[i]);
  }
  return placed;
}

template <int kDimension>
struct Search {
  using Motion = RigidMotion<kDimension>;
  using Starts = std::vector<Start<kDimension>>;
  using Few = FewPoints<kDimension>;

  const CloudModel<kDimension>& model;
  const CloudSearchOptions& options;
  Threads threads;

  [[nodiscard]] bool upright() const { return options.turns == SearchTurns::kAboutZ; }

  /// How far apart two poses are: in turn [rad, for small ones] or in shift
  /// [model radii], the greater.
  template <typename Pose, typename Other>
  [[nodiscard]] double distance(const Pose& pose, const Other& other) const {
    const typename Motion::Matrix turn =
        pose.rotation.template cast<double>() - other.rotation.template cast<double>();
    const typename Motion::Vector shift =
        pose.translation.template cast<double>() - other.translation.template cast<double>();
    // |R - R'| is sqrt(2) times the chord of the angle between them, in the
    // plane as in space.
    return std::max(turn.norm() / std::sqrt(2.0), shift.norm() / model.frame().radius_m);
  }

  /// Source and model axes laid on one another with every rotation, in the most
  /// promising places.
  [[nodiscard]] Starts all_starts(const Few& few) const {
    // Turns about z are turns from the upright axes of one cloud to those of
    // the other, not from their principal axes.
    typename Motion::Matrix onto_model = Motion::Matrix::Identity();
    if (upright()) {
      onto_model = model.frame().rotation * model.upright_frame().rotation.transpose();
    }
    const auto turns = even_rotations<kDimension>(options.starts, upright());
    PointBox<kDimension> box{model.field().points().front(), model.field().points().front()};
    for (const auto& point : model.field().points()) {
      box.low = box.low.cwiseMin(point);
      box.high = box.high.cwiseMax(point);
    }
    std::vector<Starts> of_turn(turns.size());
    parallel_for(turns.size(), threads, [&](std::size_t i) {
      Start<kDimension> start;
      start.rotation = (onto_model * turns[i]).template cast<float>();
      start.number = static_cast<int>(i);
      of_turn[i] = best_of(descend_all(placements(box, few, start), few, 0), 0.0, kPlaces);
    });
    Starts starts;
    for (const Starts& some : of_turn) starts.insert(starts.end(), some.begin(), some.end());
    for (std::size_t i = 0; i < starts.size(); ++i) starts[i].number = static_cast<int>(i);
    return starts;
  }

  /// Every start some steps on, the best first.
  [[nodiscard]] Starts descend_all(Starts starts, const Few& points, int steps) const {
    parallel_for(starts.size(), threads, [&](std::size_t i) {
      starts[i] = descend(model.field(), points, options.overlap, steps, starts[i]);
    });
    std::sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) {
      return std::pair(a.rmse_m, a.number) < std::pair(b.rmse_m, b.number);
    });
    return starts;
  }

  [[nodiscard]] static Starts best_of(Starts starts, double share, std::size_t least = kLeastKept) {
    const auto kept = std::max(
        least, static_cast<std::size_t>(std::ceil(share * static_cast<double>(starts.size()))));
    if (kept < starts.size()) starts.resize(kept);
    return starts;
  }

  struct Round {
    Starts finalists;  ///< the best first
    std::size_t starts = 0;
  };

  /// Drops the worse starts as it goes, and takes the others to the end.
  [[nodiscard]] Round finalists(std::span<const Eigen::Matrix<float, kDimension, 1>> fine) const {
    const auto few_count = static_cast<std::size_t>(options.points);
    const Few few = few_points<kDimension>(fine, spread_sample<kDimension>(fine, few_count));
    const Few more =
        few_points<kDimension>(fine, spread_sample<kDimension>(fine, kMorePoints * few_count));
    Starts starts = all_starts(few);
    const std::size_t count = starts.size();
    starts = best_of(descend_all(std::move(starts), few, kFirstSteps), kKept);
    starts = best_of(descend_all(std::move(starts), few, kSecondSteps), kKept);
    return {descend_all(std::move(starts), more, kThirdSteps), count};
  }

  /// The best of the finalists against exact nearest points, the best first,
  /// and none that came to where a better one is.
  [[nodiscard]] std::vector<Refined<kDimension>> refine_best(
      const Starts& finalists, const Placed<kDimension>& source) const {
    Starts apart;
    for (const Start<kDimension>& start : finalists) {
      if (near_any(start, apart)) continue;
      apart.push_back(start);
      if (apart.size() == kRefined) break;
    }
    std::vector<std::size_t> everything(source.fine.size());
    std::iota(everything.begin(), everything.end(), std::size_t{0});
    const Few fine = few_points<kDimension>(source.fine_single, everything);
    apart = descend_all(std::move(apart), fine, kFourthSteps);
    std::vector<Refined<kDimension>> candidates(apart.size());
    parallel_for(candidates.size(), threads, [&](std::size_t i) {
      // One that is far behind is measured, but can't win.
      const bool hopeful =
          static_cast<double>(apart[i].rmse_m) < kHopeful * static_cast<double>(apart[0].rmse_m);
      candidates[i] = refine<kDimension>(source.fine, model.field(), options.overlap,
                                         apart[i].rotation.template cast<double>(),
                                         apart[i].translation.template cast<double>(),
                                         {hopeful ? options.max_iterations : 0, kCoarseProgress});
    });
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.rmse_m < b.rmse_m; });
    std::vector<Refined<kDimension>> distinct;
    for (Refined<kDimension>& candidate : candidates) {
      if (!near_any(candidate, distinct)) distinct.push_back(std::move(candidate));
    }
    return distinct;
  }

 private:
  template <typename Pose>
  [[nodiscard]] bool near_any(const Pose& pose, const std::vector<Pose>& others) const {
    return std::any_of(others.begin(), others.end(),
                       [&](const Pose& other) { return distance(pose, other) < kSame; });
  }
};

/// From frame to frame: of the source as given, to the model as given.
template <int kDimension>
typename RigidMotion<kDimension>::Pose pose_between(const PrincipalFrame<kDimension>& source,
                                                    const PrincipalFrame<kDimension>& model,
                                                    const Refined<kDimension>& refined) {
  using Motion = RigidMotion<kDimension>;
  const typename Motion::Matrix rotation =
      model.rotation.transpose() * refined.rotation * source.rotation;
  return Motion::pose(rotation, model.centre + model.rotation.transpose() * refined.translation -
                                    rotation * source.centre);
}

}  // namespace

template <int kDimension>
CloudModel<kDimension>::CloudModel(std::span<const Point> points)
    : CloudModel(Finite{finite_points<kDimension>(points)}) {}

template <int kDimension>
CloudModel<kDimension>::CloudModel(const Finite& finite)
    : frame_(principal_frame<kDimension>(enough<kDimension>(finite.points), false)),
      upright_frame_(principal_frame<kDimension>(finite.points, true)),
      field_(field_of_model<kDimension>(finite.points, frame_)) {}

template <int kDimension>
CloudSearchResult<kDimension> search_alignment(
    std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    const CloudModel<kDimension>& model, const CloudSearchOptions& options, Threads threads) {
  CloudSearchResult<kDimension> result;
  const PointsOf<kDimension> finite = finite_points<kDimension>(source);
  if (finite.size() < kMinPoints) {
    result.match = nothing_to_align<kDimension>();
    return result;
  }
  const Search<kDimension> search{model, options, threads};
  const Placed<kDimension> placed = place<kDimension>(finite, search.upright());
  const auto [finalists, starts] = search.finalists(placed.fine_single);
  const auto refined = search.refine_best(finalists, placed);
  const Refined<kDimension>& chosen = refined.front();
  const Refined<kDimension> best =
      refine<kDimension>(placed.all, model.field(), options.overlap, chosen.rotation,
                         chosen.translation, {options.max_iterations, kFineProgress});

  result.starts = static_cast<int>(starts);
  result.finalists = static_cast<int>(finalists.size());
  result.agreeing =
      static_cast<int>(std::count_if(finalists.begin(), finalists.end(), [&](const auto& start) {
        return search.distance(start, best) < kSame;
      }));
  result.best_sampled_rmse_m = chosen.rmse_m;
  result.match = judge<kDimension>(finite, pose_between(placed.frame, model.frame(), best), best,
                                   model, options.least_explained);
  if (refined.size() > 1) {
    const Refined<kDimension>& other = refined[1];
    result.runner_up = {pose_between(placed.frame, model.frame(), other), other.rmse_m};
    // Distances far below the voxels' size tell nothing: a cloud laid on itself
    // has none at all.
    const double floor_m = 0.1 * static_cast<double>(model.field().frame().resolution_m);
    result.ambiguous = other.rmse_m < options.rival_ratio * std::max(chosen.rmse_m, floor_m);
  }
  if (result.ambiguous) result.match = with_rival(result.match, result.runner_up->target_T_source);
  return result;
}

template class CloudModel<2>;
template class CloudModel<3>;
template CloudSearchResult<2> search_alignment<2>(std::span<const Eigen::Vector2d>,
                                                  const CloudModel<2>&, const CloudSearchOptions&,
                                                  Threads);
template CloudSearchResult<3> search_alignment<3>(std::span<const Eigen::Vector3d>,
                                                  const CloudModel<3>&, const CloudSearchOptions&,
                                                  Threads);

}  // namespace loopstone
