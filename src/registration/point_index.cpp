#include "loopstone/registration/point_index.hpp"

#include <cmath>
#include <utility>

#include "registration/kd_tree.hpp"

namespace loopstone {

template <int kDimension>
PointIndex<kDimension>::PointIndex(std::vector<Point> points)
    : points_(std::move(points)), tree_(std::make_unique<KdTree<kDimension>>(points_)) {}
template <int kDimension>
PointIndex<kDimension>::PointIndex(PointIndex&&) noexcept = default;
template <int kDimension>
PointIndex<kDimension>& PointIndex<kDimension>::operator=(PointIndex&&) noexcept = default;
template <int kDimension>
PointIndex<kDimension>::~PointIndex() = default;

template <int kDimension>
std::optional<Neighbour> PointIndex<kDimension>::nearest(const Point& query,
                                                         double max_distance_m) const {
  const NearestPoint found = tree_->nearest(query, max_distance_m);
  if (found.index < 0) return std::nullopt;
  return Neighbour{static_cast<std::size_t>(found.index), std::sqrt(found.squared_distance_m2)};
}

template <int kDimension>
NearestPoint PointIndex<kDimension>::nearest_point(const Point& query, double max_distance_m,
                                                   std::int32_t hint) const {
  return tree_->nearest(query, max_distance_m,
                        hint < 0 ? nullptr : &points_[static_cast<std::size_t>(hint)], hint);
}

template <int kDimension>
std::vector<Neighbour> PointIndex<kDimension>::nearest_several(const Point& query,
                                                               std::size_t count) const {
  std::vector<typename KdTree<kDimension>::Found> found(std::min(count, tree_->size()));
  const std::size_t size = tree_->nearest_several(query, found.size(), found.data());
  std::vector<Neighbour> result;
  result.reserve(size);
  for (std::size_t i = 0; i < size; ++i) {
    result.push_back(
        {static_cast<std::size_t>(found[i].index), std::sqrt(found[i].squared_distance_m2)});
  }
  return result;
}

template class PointIndex<2>;
template class PointIndex<3>;

}  // namespace loopstone
