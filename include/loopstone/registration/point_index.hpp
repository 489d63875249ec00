#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace loopstone {

struct Neighbour {
  std::size_t index = 0;
  double distance_m = 0.0;
};

/// The nearest point, and how long the answer stands: while the query moves by less than half the
/// gap between the two distances, the nearest point stays the same.
struct NearestPoint {
  std::int32_t index = -1;           ///< -1: no point within reach
  double squared_distance_m2 = 0.0;  ///< to that point
  double others_m = 0.0;  ///< every other point is at least this far; with index -1 all points are
};

template <int kDimension>
class KdTree;

/// Points that can be asked for the nearest ones: a k-d tree. Built once, then read by any number
/// of threads. kDimension is 2 or 3. Of equally near points the one with the lowest number is the
/// nearest, so the answers are those of a search through all points, to the bit.
/// Source: Friedman, Bentley and Finkel 1977; distances to boxes kept along the way, Arya and Mount
/// 1993.
template <int kDimension>
class PointIndex {
 public:
  using Point = Eigen::Matrix<double, kDimension, 1>;

  /// Points that are not finite are left out, but keep their number.
  explicit PointIndex(std::vector<Point> points);
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;
  ~PointIndex();

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }

  /// The nearest point no farther than this.
  [[nodiscard]] std::optional<Neighbour> nearest(const Point& query, double max_distance_m) const;
  /// The same with the distance of the others.
  /// \param hint  the number of a point that may be near, such as the answer to a query like this
  ///              one; it makes the search short, and changes nothing else. -1: none.
  [[nodiscard]] NearestPoint nearest_point(const Point& query, double max_distance_m,
                                           std::int32_t hint = -1) const;
  /// The `count` nearest points (fewer when there are fewer), nearest first.
  [[nodiscard]] std::vector<Neighbour> nearest_several(const Point& query, std::size_t count) const;

  /// For algorithms of this library that search without allocating.
  [[nodiscard]] const KdTree<kDimension>& tree() const { return *tree_; }

 private:
  std::vector<Point> points_;
  std::unique_ptr<KdTree<kDimension>> tree_;
};

extern template class PointIndex<2>;
extern template class PointIndex<3>;

}  // namespace loopstone
