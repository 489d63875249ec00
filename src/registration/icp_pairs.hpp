#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/registration/icp.hpp"

namespace loopstone {

/// The metric itself. Throws UsageError for kLine in space.
[[nodiscard]] IcpMetric metric_for(IcpMetric metric, int dimension);

/// What is aligned: points, and the patches around them when the metric wants them.
template <int kDimension>
struct IcpSource {
  std::span<const Eigen::Matrix<double, kDimension, 1>> points;
  std::span<const SurfacePatch<kDimension>> patches;
};

/// A source point, the target point it belongs to, and what the metric makes of the two.
template <int kDimension>
struct IcpPair {
  using Vector = Eigen::Matrix<double, kDimension, 1>;

  Vector source;  ///< source frame
  Vector arm;     ///< from the source frame's origin to the point, target axes
  Vector offset;  ///< from the anchor (a point of the target's surface) to the point, target frame
  Vector
      normal;  ///< point: zero; line, plane: of the target's surface; gicp: of the target's patch
  Vector turned_normal;              ///< gicp: of the source's patch, target axes
  double squared_distance_m2 = 0.0;  ///< to the nearest target point
  double squared_residual_m2 = 0.0;  ///< of the metric
  double weight = 1.0;               ///< of the kernel; 0: trimmed
  std::int32_t target = 0;           ///< the number of the target point
};

/// Finds the pairs of all source points, again and again while the pose moves.
template <int kDimension>
class IcpPairFinder {
 public:
  using Motion = RigidMotion<kDimension>;
  using Vector = typename Motion::Vector;
  using Pair = IcpPair<kDimension>;

  /// Both must outlive the finder.
  IcpPairFinder(const IcpSource<kDimension>& source, const IcpCloud<kDimension>& target,
                IcpMetric metric);

  /// Pairs no farther apart than this, in the source's order, all with weight 1. Valid until the
  /// next call.
  [[nodiscard]] std::span<Pair> find(const typename Motion::Pose& target_T_source,
                                     double max_pair_distance_m);

  /// How many source points have a target point no farther than this.
  [[nodiscard]] std::size_t count_within(const typename Motion::Pose& target_T_source,
                                         double distance_m);

  /// Source points that are finite.
  [[nodiscard]] std::size_t finite_points() const { return queries_.size(); }

 private:
  /// The last answer for a source point. It stands while the point has moved less than the gap to
  /// the others.
  struct Query {
    Vector point;
    Vector asked_at = Vector::Zero();
    double others_m = -1.0;  ///< from there; negative: nothing known
    std::int32_t source = 0;
    std::int32_t nearest = -1;
  };
  /// The neighbours of a target point that end the segments on either side of it; -1: none.
  struct Segments {
    std::int32_t first = -1;
    std::int32_t second = -1;
    bool known = false;
  };

  /// \param hint  a target point that may be near, when the query has none of its own
  [[nodiscard]] NearestPoint nearest(Query& query, const Vector& moved, double reach_m,
                                     std::int32_t hint) const;
  [[nodiscard]] const Segments& segments_of(std::int32_t target);
  /// False where the metric can't use the pair.
  [[nodiscard]] bool measure(Pair& pair, const Vector& moved, std::int32_t source,
                             const typename Motion::Matrix& rotation);

  IcpSource<kDimension> source_;
  const IcpCloud<kDimension>& target_;
  IcpMetric metric_;
  std::vector<Query> queries_{};
  std::vector<Pair> pairs_{};
  std::vector<Segments> segments_{};
};

/// The weight matrix of generalised ICP for two unit normals n, m on the target's axes (zero: no
/// surface),
///
///   M = 2 e (C_n + C_m)^-1, C_n = 1 - (1 - e) n n^T,
///
/// which by Woodbury's identity is a unit matrix and two dyads: M = scale (1 + same (n n^T + m m^T)
/// + cross (n m^T + m n^T)).
struct GicpWeight {
  double scale;
  double same;
  double cross;

  /// \param cosine  n^T m
  explicit GicpWeight(double cosine);
};

/// Sets the weight of all but the closest share to 0, of the others by the kernel. Returns the mean
/// cost of those.
template <int kDimension>
double weigh(std::span<IcpPair<kDimension>> pairs, double trim_fraction, RobustKernel kernel,
             double kernel_width_m);

extern template class IcpPairFinder<2>;
extern template class IcpPairFinder<3>;

}  // namespace loopstone
