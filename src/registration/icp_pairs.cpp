#include "registration/icp_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

namespace {

/// Of the covariance of a piece of surface, across it; along it is 1 (Segal 2009).
constexpr double kAcross = 1e-3;
/// The ends of a segment are chosen among so many neighbours.
constexpr std::size_t kSegmentNeighbours = 16;
/// A segment should be this many times longer than the noise at its ends is wide, or its direction
/// is chance.
constexpr double kSegmentThicknesses = 6.0;
/// Points without a partner are looked for a bit farther than asked, so that they need not be
/// looked for each time.
constexpr double kBeyondReach = 1.25;
constexpr double kRounding = 1.0 - 1e-12;

}  // namespace

IcpMetric metric_for(IcpMetric metric, int dimension) {
  if (metric == IcpMetric::kLine && dimension != 2) {
    throw UsageError("metric: 'line' is for the plane; use plane in space");
  }
  return metric;
}

template <int kDimension>
IcpPairFinder<kDimension>::IcpPairFinder(const IcpSource<kDimension>& source,
                                         const IcpCloud<kDimension>& target, IcpMetric metric)
    : source_(source), target_(target), metric_(metric) {
  queries_.reserve(source.points.size());
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    if (!is_usable_point(source.points[i])) continue;
    queries_.emplace_back();
    queries_.back().point = source.points[i];
    queries_.back().source = static_cast<std::int32_t>(i);
  }
  pairs_.reserve(queries_.size());
  if (metric == IcpMetric::kLine) segments_.resize(target.points().size());
}

template <int kDimension>
NearestPoint IcpPairFinder<kDimension>::nearest(Query& query, const Vector& moved, double reach_m,
                                                std::int32_t hint) const {
  NearestPoint answer;
  if (query.nearest >= 0) {
    answer.index = query.nearest;
    answer.squared_distance_m2 =
        (moved - target_.points()[static_cast<std::size_t>(query.nearest)]).squaredNorm();
  }
  // The others have come no closer than the point has moved. While the last answer is nearer than
  // that, it stands.
  if (query.others_m > 0.0) {
    const double others_m = query.others_m * kRounding - (moved - query.asked_at).norm();
    if (others_m > 0.0 && query.nearest < 0 && others_m > reach_m) return answer;
    if (others_m > 0.0 && query.nearest >= 0 && answer.squared_distance_m2 < others_m * others_m) {
      if (answer.squared_distance_m2 > reach_m * reach_m) answer.index = -1;
      return answer;
    }
  }
  answer = target_.nearest_point(moved, kBeyondReach * reach_m,
                                 query.nearest >= 0 ? query.nearest : hint);
  query.asked_at = moved;
  query.others_m = answer.others_m;
  query.nearest = answer.index;
  if (answer.squared_distance_m2 > reach_m * reach_m) answer.index = -1;
  return answer;
}

template <int kDimension>
const typename IcpPairFinder<kDimension>::Segments& IcpPairFinder<kDimension>::segments_of(
    std::int32_t target) {
  Segments& segments = segments_[static_cast<std::size_t>(target)];
  if (segments.known) return segments;
  segments.known = true;
  const auto& points = target_.points();
  const Vector& point = points[static_cast<std::size_t>(target)];
  const SurfacePatch<kDimension>& patch = target_.patches[static_cast<std::size_t>(target)];
  const double least_m = kSegmentThicknesses * patch.thickness_m;
  for (const Neighbour& neighbour : target_.index.nearest_several(point, kSegmentNeighbours)) {
    // Beyond the patch's neighbours another surface begins. Points of one place make no segment.
    if (neighbour.distance_m > patch.radius_m || !(neighbour.distance_m > 0.0)) continue;
    const Vector arm = points[neighbour.index] - point;
    const auto number = static_cast<std::int32_t>(neighbour.index);
    const auto better = [&](std::int32_t kept) {
      // The nearest one that is far enough, else the farthest.
      if (kept < 0) return true;
      return (points[static_cast<std::size_t>(kept)] - point).norm() < least_m;
    };
    if (segments.first < 0 ||
        arm.dot(points[static_cast<std::size_t>(segments.first)] - point) > 0.0) {
      if (better(segments.first)) segments.first = number;
    } else if (better(segments.second)) {
      segments.second = number;
    }
  }
  return segments;
}

template <int kDimension>
bool IcpPairFinder<kDimension>::measure(Pair& pair, const Vector& moved, std::int32_t source,
                                        const typename Motion::Matrix& rotation) {
  const auto target = static_cast<std::size_t>(pair.target);
  const Vector& point = target_.points()[target];
  const SurfacePatch<kDimension>& patch = target_.patches[target];
  switch (metric_) {
    case IcpMetric::kPoint:
      pair.offset = moved - point;
      pair.normal = Vector::Zero();
      pair.squared_residual_m2 = pair.squared_distance_m2;
      return true;
    case IcpMetric::kPlane: {
      if (!patch.flat) return false;
      pair.offset = moved - patch.anchor;
      pair.normal = patch.normal;
      const double across = pair.normal.dot(pair.offset);
      pair.squared_residual_m2 = across * across;
      return true;
    }
    case IcpMetric::kLine: {
      if constexpr (kDimension == 2) {
        const Segments& segments = segments_of(pair.target);
        std::int32_t end = segments.first;
        if (end < 0) return false;
        const Vector towards_end = target_.points()[static_cast<std::size_t>(end)] - point;
        if (segments.second >= 0 && towards_end.dot(moved - point) < 0.0) end = segments.second;
        const Vector along = target_.points()[static_cast<std::size_t>(end)] - point;
        pair.offset = moved - point;
        pair.normal = Vector(-along.y(), along.x()).normalized();
        const double across = pair.normal.dot(pair.offset);
        pair.squared_residual_m2 = across * across;
        return true;
      }
      return false;
    }
    case IcpMetric::kGicp: {
      pair.offset = moved - point;
      pair.normal = patch.normal;
      pair.turned_normal = rotation * source_.patches[static_cast<std::size_t>(source)].normal;
      const GicpWeight weight(pair.normal.dot(pair.turned_normal));
      const double n = pair.normal.dot(pair.offset);
      const double m = pair.turned_normal.dot(pair.offset);
      pair.squared_residual_m2 =
          weight.scale *
          (pair.offset.squaredNorm() + weight.same * (n * n + m * m) + 2.0 * weight.cross * n * m);
      return true;
    }
  }
  return false;
}

template <int kDimension>
std::span<IcpPair<kDimension>> IcpPairFinder<kDimension>::find(
    const typename Motion::Pose& target_T_source, double max_pair_distance_m) {
  pairs_.clear();
  const typename Motion::Matrix rotation = Motion::rotation(target_T_source);
  const Vector translation = Motion::translation(target_T_source);
  std::int32_t hint = -1;  // source points that follow each other tend to be neighbours
  for (Query& query : queries_) {
    const Vector arm = rotation * query.point;
    const Vector moved = arm + translation;
    const NearestPoint found = nearest(query, moved, max_pair_distance_m, hint);
    hint = query.nearest;
    if (found.index < 0) continue;
    Pair pair;
    pair.source = query.point;
    pair.arm = arm;
    pair.target = found.index;
    pair.squared_distance_m2 = found.squared_distance_m2;
    if (measure(pair, moved, query.source, rotation)) pairs_.push_back(pair);
  }
  return pairs_;
}

template <int kDimension>
std::size_t IcpPairFinder<kDimension>::count_within(const typename Motion::Pose& target_T_source,
                                                    double distance_m) {
  const typename Motion::Matrix rotation = Motion::rotation(target_T_source);
  const Vector translation = Motion::translation(target_T_source);
  return static_cast<std::size_t>(
      std::count_if(queries_.begin(), queries_.end(), [&](Query& query) {
        const Vector moved = rotation * query.point + translation;
        return nearest(query, moved, distance_m, -1).index >= 0;
      }));
}

GicpWeight::GicpWeight(double cosine) : scale(kAcross), same(0.0), cross(0.0) {
  constexpr double kDiagonal = 2.0 / (1.0 - kAcross) - 1.0;
  const double determinant = kDiagonal * kDiagonal - cosine * cosine;
  same = kDiagonal / determinant;
  cross = cosine / determinant;
}

template <int kDimension>
double weigh(std::span<IcpPair<kDimension>> pairs, double trim_fraction, RobustKernel kernel,
             double kernel_width_m) {
  const auto kept =
      static_cast<std::size_t>(std::ceil(trim_fraction * static_cast<double>(pairs.size())));
  double farthest = std::numeric_limits<double>::infinity();
  if (kept > 0 && kept < pairs.size()) {
    std::vector<double> distances;
    distances.reserve(pairs.size());
    for (const auto& pair : pairs) distances.push_back(pair.squared_distance_m2);
    const auto last = distances.begin() + static_cast<std::ptrdiff_t>(kept) - 1;
    std::nth_element(distances.begin(), last, distances.end());
    farthest = *last;
  }
  const bool alike = kernel == RobustKernel::kNone || kernel_width_m <= 0.0;
  double cost = 0.0;
  std::size_t used = 0;
  for (auto& pair : pairs) {
    if (pair.squared_distance_m2 > farthest) {
      pair.weight = 0.0;
      continue;
    }
    const RobustValue value = alike ? RobustValue{pair.squared_residual_m2, 1.0}
                                    : evaluate(kernel, kernel_width_m, pair.squared_residual_m2);
    pair.weight = value.weight;
    cost += value.cost;
    ++used;
  }
  return used > 0 ? cost / static_cast<double>(used) : 0.0;
}

template class IcpPairFinder<2>;
template class IcpPairFinder<3>;
template double weigh<2>(std::span<IcpPair<2>>, double, RobustKernel, double);
template double weigh<3>(std::span<IcpPair<3>>, double, RobustKernel, double);

}  // namespace loopstone
