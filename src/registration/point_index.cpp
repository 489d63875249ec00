#include "loopstone/registration/point_index.hpp"

#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <utility>

namespace loopstone {

namespace {

/// The finite points, as nanoflann wants to see them.
template <int kDimension>
struct Cloud {
  std::vector<Eigen::Matrix<double, kDimension, 1>> points;
  std::vector<std::size_t> finite;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return finite.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[finite[index]](static_cast<Eigen::Index>(axis));
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

template <int kDimension>
struct PointIndex<kDimension>::Tree {
  using Cloud = loopstone::Cloud<kDimension>;
  using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>,
                                                     Cloud, kDimension, std::size_t>;
  Cloud cloud;
  KdTree tree;

  explicit Tree(std::vector<Point> points)
      : cloud(make_cloud(std::move(points))),
        tree(kDimension, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {}

  static Cloud make_cloud(std::vector<Point> points) {
    Cloud cloud{std::move(points), {}};
    cloud.finite.reserve(cloud.points.size());
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (cloud.points[i].allFinite()) cloud.finite.push_back(i);
    }
    return cloud;
  }
};

template <int kDimension>
PointIndex<kDimension>::PointIndex(std::vector<Point> points)
    : tree_(std::make_unique<Tree>(std::move(points))) {}
template <int kDimension>
PointIndex<kDimension>::PointIndex(PointIndex&&) noexcept = default;
template <int kDimension>
PointIndex<kDimension>& PointIndex<kDimension>::operator=(PointIndex&&) noexcept = default;
template <int kDimension>
PointIndex<kDimension>::~PointIndex() = default;

template <int kDimension>
const std::vector<typename PointIndex<kDimension>::Point>& PointIndex<kDimension>::points() const {
  return tree_->cloud.points;
}

template <int kDimension>
std::optional<Neighbour> PointIndex<kDimension>::nearest(const Point& query,
                                                         double max_distance_m) const {
  if (tree_->cloud.finite.empty() || !query.allFinite()) return std::nullopt;
  std::size_t index = 0;
  double squared_distance = 0.0;
  nanoflann::KNNResultSet<double, std::size_t> found(1);
  found.init(&index, &squared_distance);
  tree_->tree.findNeighbors(found, query.data(), nanoflann::SearchParams{});
  if (squared_distance > max_distance_m * max_distance_m) return std::nullopt;
  return Neighbour{tree_->cloud.finite[index], std::sqrt(squared_distance)};
}

template <int kDimension>
std::vector<Neighbour> PointIndex<kDimension>::nearest_several(const Point& query,
                                                               std::size_t count) const {
  if (tree_->cloud.finite.empty() || !query.allFinite() || count == 0) return {};
  std::vector<std::size_t> indices(count);
  std::vector<double> squared_distances(count);
  nanoflann::KNNResultSet<double, std::size_t> found(count);
  found.init(indices.data(), squared_distances.data());
  tree_->tree.findNeighbors(found, query.data(), nanoflann::SearchParams{});
  std::vector<Neighbour> result;
  result.reserve(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    result.push_back({tree_->cloud.finite[indices[i]], std::sqrt(squared_distances[i])});
  }
  return result;
}

template class PointIndex<2>;
template class PointIndex<3>;

std::vector<std::optional<Eigen::Vector2d>> line_normals(const PointIndex<2>& index,
                                                         std::size_t neighbours,
                                                         double max_radius_m, double max_width) {
  constexpr std::size_t kLeastNeighbours = 3;
  std::vector<std::optional<Eigen::Vector2d>> normals(index.points().size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    std::size_t count = 0;
    const Eigen::Vector2d& centre = index.points()[i];
    for (const Neighbour& neighbour : index.nearest_several(centre, neighbours)) {
      if (neighbour.distance_m > max_radius_m) break;
      const Eigen::Vector2d arm = index.points()[neighbour.index] - centre;
      sum += arm;
      squares += arm * arm.transpose();
      ++count;
    }
    if (count < kLeastNeighbours) continue;
    const Eigen::Matrix2d scatter = squares - sum * sum.transpose() / static_cast<double>(count);
    // Eigenvalues of a symmetric 2x2 matrix: middle +- spread; the line runs at half the angle of (difference, 2 xy).
    const double middle = 0.5 * (scatter(0, 0) + scatter(1, 1));
    const double difference = 0.5 * (scatter(0, 0) - scatter(1, 1));
    const double spread = std::hypot(difference, scatter(0, 1));
    const double width2 = std::max(middle - spread, 0.0);
    const double length2 = middle + spread;
    if (!(length2 > 0.0) || width2 > max_width * max_width * length2) continue;
    const double along = 0.5 * std::atan2(scatter(0, 1), difference);
    normals[i] = Eigen::Vector2d(-std::sin(along), std::cos(along));
  }
  return normals;
}

}  // namespace loopstone
