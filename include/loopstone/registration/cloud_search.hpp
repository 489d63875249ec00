#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/registration/distance_field.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// The point that a cloud is described about, its principal axes and its size.
template <int kDimension>
struct PrincipalFrame {
  using Motion = RigidMotion<kDimension>;

  typename Motion::Vector centre = Motion::Vector::Zero();  ///< the centroid [m]
  /// Turns the cloud's axes onto the principal ones, shortest first; their signs and, where lengths
  /// are equal, their order are arbitrary.
  typename Motion::Matrix rotation = Motion::Matrix::Identity();
  double radius_m = 0.0;  ///< root mean square distance of the points from the centre
};

/// A cloud that others are aligned to, without a guess: its distance field, on its principal axes.
/// Made once, then searched by any number of threads.
template <int kDimension>
class CloudModel {
 public:
  using Point = Eigen::Matrix<double, kDimension, 1>;

  /// \param points  [m]; those that are not finite are ignored
  /// Throws DataError when fewer than 3 points are finite.
  /// Cost: O(points + voxels); about a million voxels at most.
  explicit CloudModel(std::span<const Point> points);

  [[nodiscard]] const PrincipalFrame<kDimension>& frame() const { return frame_; }
  /// The axes of the upright cloud: turned about z alone.
  [[nodiscard]] const PrincipalFrame<kDimension>& upright_frame() const { return upright_frame_; }
  /// In frame(): on the principal axes, about the centre.
  [[nodiscard]] const DistanceField<kDimension>& field() const { return field_; }

 private:
  struct Finite {
    std::vector<Point> points;
  };
  explicit CloudModel(const Finite& finite);

  PrincipalFrame<kDimension> frame_;
  PrincipalFrame<kDimension> upright_frame_;
  DistanceField<kDimension> field_;
};

/// Which turns are tried, in space; in the plane there is but one axis.
enum class SearchTurns {
  kAny,
  kAboutZ,  ///< for clouds that both stand upright; refinement may tilt them
};

constexpr auto words_of(SearchTurns /*any*/) {
  using enum SearchTurns;
  return std::array{Word{kAny, "any"}, Word{kAboutZ, "about_z"}};
}

struct CloudSearchOptions {
  SearchTurns turns = SearchTurns::kAny;
  int starts = 256;
  int points = 80;
  double overlap = 1.0;
  double rival_ratio = 1.1;
  double least_explained = 0.5;
  int max_iterations = 100;
};

template <typename Visitor>
void visit_options(CloudSearchOptions& options, Visitor&& visit) {
  visit("turns", options.turns,
        "turns to try, in space: all, or those about the z axis of clouds that both stand upright");
  visit("starts", options.starts, Range{1, 1e6}, "about so many turns are tried, evenly spread");
  visit("points", options.points, Range{10, 1e5},
        "source points that all starts are tried with; the best are tried with more");
  visit("overlap", options.overlap, Range{0.05, 1.0},
        "share of the source that the model holds; the farthest points are left out");
  visit("rival_ratio", options.rival_ratio, Range{1.0, 100.0},
        "another pose with less than so many times the best rmse makes the answer ambiguous");
  visit("least_explained", options.least_explained, Range{0.0, 1.0},
        "share of the source that must lie within a fourteenth of the model's radius from it, else "
        "not_converged");
  visit("max_iterations", options.max_iterations, Range{1, 10000}, "steps of the last refinement");
}

/// Where a cloud lies in a model's frame, as found without a guess.
template <int kDimension>
struct CloudSearchResult {
  struct Rival {
    typename RigidMotion<kDimension>::Pose target_T_source{};
    double rmse_m = 0.0;  ///< over the same points as best_sampled_rmse_m
  };

  BasicMatchResult<kDimension> match{};
  int starts = 0;  ///< rotations that were tried
  int finalists =
      0;  ///< of these, refined to the end of the search; the others were dropped on the way
  int agreeing = 0;  ///< of the finalists, those that ended at the answer
  /// The best pose elsewhere, if any finalist ended there.
  std::optional<Rival> runner_up{};
  double best_sampled_rmse_m =
      0.0;  ///< of the answer, over the sampled points that it was chosen with
  bool ambiguous =
      false;  ///< the runner-up fits as well: a symmetric shape, or too small a part of it
};

/// Aligns a cloud, which may be a part of the model alone, to the model from no guess at all: lays
/// the source on the model with many turns, in the two most promising of many places each, lets
/// each start slide down the model's distance field by Gauss-Newton with few points, drops the
/// worse ones as it goes, and refines the best distinct ones with all points against exact nearest
/// points, to the minimum of
///
///   rmse^2 = mean over source points of |T p_i - nearest model point|^2
///            (over the closest `overlap` of them)
///
/// Both clouds are described on their principal axes and the rotations are symmetric about these,
/// so moving a cloud moves the answer with it and changes nothing else.
///
/// \param source  [m], source frame, on the model's scale; points that are not finite are ignored
/// \return match: target_T_source with rmse_m over all points (the closest `overlap` of them).
///         score = share of the source within 1/14 of the model's radius from it.
///         kTooFewPairs: fewer than 3 finite points; the pose is the identity.
///         kNotConverged: score < least_explained, or the iterations ran out.
///         kDegenerate: a motion is unobserved (a turn about a bottle's axis), or the runner-up
///         fits as well (`ambiguous`); the covariance is that of the answer and its rival together.
///         Else the covariance is H^-1 M H^-1, with H of the distances across the model's surface
///         and M of the residuals as they are, those that share a model point counted as one.
/// Cost: O(starts * points + iterations * source). Deterministic: the same bytes for any number of
/// threads. Thread-safe.
/// Source: Fitzgibbon 2003, "Robust registration of 2D and 3D point sets" (distance field,
/// Gauss-Newton); Chetverikov 2002 (overlap).
template <int kDimension>
[[nodiscard]] CloudSearchResult<kDimension> search_alignment(
    std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    const CloudModel<kDimension>& model, const CloudSearchOptions& options = {},
    Threads threads = {1});

extern template class CloudModel<2>;
extern template class CloudModel<3>;
extern template CloudSearchResult<2> search_alignment<2>(std::span<const Eigen::Vector2d>,
                                                         const CloudModel<2>&,
                                                         const CloudSearchOptions&, Threads);
extern template CloudSearchResult<3> search_alignment<3>(std::span<const Eigen::Vector3d>,
                                                         const CloudModel<3>&,
                                                         const CloudSearchOptions&, Threads);

}  // namespace loopstone
