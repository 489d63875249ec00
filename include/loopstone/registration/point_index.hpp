#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace loopstone {

struct Neighbour {
  std::size_t index = 0;
  double distance_m = 0.0;
};

/// Points that can be asked for the nearest ones: a k-d tree. Built once, then read by any number of threads.
/// kDimension is 2 or 3.
template <int kDimension>
class PointIndex {
 public:
  using Point = Eigen::Matrix<double, kDimension, 1>;

  /// Points that are not finite are left out, but keep their number.
  explicit PointIndex(std::vector<Point> points);
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;
  ~PointIndex();

  [[nodiscard]] const std::vector<Point>& points() const;

  /// The nearest point no farther than this; of equally near ones any, but always the same.
  [[nodiscard]] std::optional<Neighbour> nearest(const Point& query, double max_distance_m) const;
  /// The `count` nearest points (fewer when there are fewer), nearest first.
  [[nodiscard]] std::vector<Neighbour> nearest_several(const Point& query, std::size_t count) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

extern template class PointIndex<2>;
extern template class PointIndex<3>;

/// Which way the curve through planar points faces at each of them: unit normals, side arbitrary; nothing where the
/// neighbourhood is no line (a corner, clutter, too few points).
///
/// \param neighbours    how many nearest points, itself included, make a neighbourhood
/// \param max_radius_m  neighbours farther away are left out
/// \param max_width     [0, 1], greatest ratio of the neighbourhood's width to its length
/// Cost: O(points * neighbours).
[[nodiscard]] std::vector<std::optional<Eigen::Vector2d>> line_normals(const PointIndex<2>& index,
                                                                       std::size_t neighbours,
                                                                       double max_radius_m,
                                                                       double max_width = 0.35);

}  // namespace loopstone
