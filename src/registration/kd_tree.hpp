#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "loopstone/registration/point_index.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

/// The tree inside PointIndex. Leaves hold up to kLeafSize points, side by side in memory; an inner
/// node keeps how far its two halves reach along the axis that divides them. Squared distances are
/// summed x, y, z from their first term, so the distance to a box, rounded, never exceeds that to a
/// point in it, and pruning loses nothing, not even ties.
template <int kDimension>
class KdTree {
 public:
  using Point = Eigen::Matrix<double, kDimension, 1>;

  explicit KdTree(const std::vector<Point>& points) {
    entries_.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_usable_point(points[i])) entries_.push_back({points[i], static_cast<std::int32_t>(i)});
    }
    nodes_.reserve(2 * entries_.size() / (kLeafSize / 2) + 1);
    if (!entries_.empty()) build(0, static_cast<std::int32_t>(entries_.size()));
  }

  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] std::size_t size() const { return entries_.size(); }

  /// See PointIndex. `hint` is a point that is in the tree, with its number.
  [[nodiscard]] NearestPoint nearest(const Point& query, double max_distance_m,
                                     const Point* hint_point = nullptr,
                                     std::int32_t hint = -1) const {
    NearestPoint none;
    none.others_m = max_distance_m;
    if (entries_.empty() || !is_usable_point(query)) return none;
    NearestSearch search{query, -1, max_distance_m * max_distance_m,
                         std::numeric_limits<double>::infinity()};
    if (hint_point != nullptr) {
      const double squared = squared_distance(*hint_point, query);
      if (squared <= search.best) {
        search.best = squared;
        search.index = hint;
      }
    }
    std::array<double, kDimension> offsets{};
    descend(0, offsets, search);
    if (search.index < 0) return none;
    return {search.index, search.best, std::sqrt(search.others)};
  }

  struct Found {
    double squared_distance_m2;
    std::int32_t index;
    friend bool operator<(const Found& a, const Found& b) {
      return a.squared_distance_m2 < b.squared_distance_m2 ||
             (a.squared_distance_m2 == b.squared_distance_m2 && a.index < b.index);
    }
  };

  /// Fills `found` with the nearest points, nearest first; returns how many there are.
  std::size_t nearest_several(const Point& query, std::size_t count, Found* found) const {
    if (entries_.empty() || count == 0 || !is_usable_point(query)) return 0;
    SeveralSearch search{query, found, count, 0, std::numeric_limits<double>::infinity()};
    std::array<double, kDimension> offsets{};
    descend(0, offsets, search);
    return search.size;
  }

  /// visit(point, index, squared distance) for every point no farther than this, in the tree's
  /// order.
  template <typename Visitor>
  void for_each_within(const Point& query, double radius_m, Visitor&& visit) const {
    if (entries_.empty() || !is_usable_point(query)) return;
    BallSearch<Visitor> search{query, radius_m * radius_m, visit};
    std::array<double, kDimension> offsets{};
    descend(0, offsets, search);
  }

  /// visit(point, index) for all points in the order of the leaves: neighbours come soon after each
  /// other.
  template <typename Visitor>
  void for_each(Visitor&& visit) const {
    for (const Entry& entry : entries_) visit(entry.point, entry.index);
  }

  [[nodiscard]] static double squared_distance(const Point& a, const Point& b) {
    double sum = 0.0;
    for (int k = 0; k < kDimension; ++k) {
      const double d = a(k) - b(k);
      sum += d * d;
    }
    return sum;
  }

 private:
  static constexpr std::int32_t kLeafSize = 12;
  /// In place of the axis that divides a node.
  static constexpr std::int32_t kLeaf = -1;
  static constexpr std::int32_t kOnePlace =
      -2;  ///< a leaf of any size whose points are all the same

  struct Entry {
    Point point;
    std::int32_t index;
  };
  struct Node {
    double left_end = 0.0;     ///< greatest coordinate of the left half
    double right_start = 0.0;  ///< least coordinate of the right half
    std::int32_t axis = kLeaf;
    std::int32_t begin = 0;  ///< leaf: its entries
    std::int32_t end = 0;
    std::int32_t right = 0;  ///< the left half follows its parent
  };

  struct NearestSearch {
    const Point& query;
    std::int32_t index;
    double best;    ///< squared
    double others;  ///< squared

    [[nodiscard]] double bound() const { return best; }
    [[nodiscard]] static std::int32_t equals_matter() { return 2; }
    void pruned(double squared) { others = std::min(others, squared); }
    void offer(const Entry& entry, double squared) {
      if (entry.index == index) return;
      if (squared < best || (squared == best && (index < 0 || entry.index < index))) {
        if (index >= 0) others = std::min(others, best);
        best = squared;
        index = entry.index;
      } else {
        others = std::min(others, squared);
      }
    }
  };

  struct SeveralSearch {
    const Point& query;
    Found* found;
    std::size_t capacity;
    std::size_t size;
    double worst;

    [[nodiscard]] double bound() const { return worst; }
    [[nodiscard]] std::int32_t equals_matter() const { return static_cast<std::int32_t>(capacity); }
    void pruned(double) {}
    void offer(const Entry& entry, double squared) {
      const Found candidate{squared, entry.index};
      if (size == capacity) {
        if (!(candidate < found[size - 1])) return;
      } else {
        ++size;
      }
      std::size_t place = size - 1;
      for (; place > 0 && candidate < found[place - 1]; --place) found[place] = found[place - 1];
      found[place] = candidate;
      if (size == capacity) worst = found[size - 1].squared_distance_m2;
    }
  };

  template <typename Visitor>
  struct BallSearch {
    const Point& query;
    double squared_radius;
    Visitor& visit;

    [[nodiscard]] double bound() const { return squared_radius; }
    [[nodiscard]] static std::int32_t equals_matter() {
      return std::numeric_limits<std::int32_t>::max();
    }
    void pruned(double) {}
    void offer(const Entry& entry, double squared) {
      if (squared <= squared_radius) visit(entry.point, entry.index, squared);
    }
  };

  /// offsets: squared distance of the query from the node's box along each axis.
  template <typename Search>
  void descend(std::int32_t index, std::array<double, kDimension>& offsets, Search& search) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.axis < 0) {
      // Of points at one place the first ones say it all: the nearest of equals is the one of least
      // index.
      const std::int32_t end =
          node.axis == kOnePlace
              ? node.begin + std::min(node.end - node.begin, search.equals_matter())
              : node.end;
      for (std::int32_t i = node.begin; i < end; ++i) {
        const Entry& entry = entries_[static_cast<std::size_t>(i)];
        search.offer(entry, squared_distance(entry.point, search.query));
      }
      return;
    }
    const auto axis = static_cast<std::size_t>(node.axis);
    const double coordinate = search.query(node.axis);
    const double to_left = coordinate - node.left_end;      // > 0: the left half is this far
    const double to_right = node.right_start - coordinate;  // > 0: the right half is
    const double kept = offsets[axis];
    const auto visit = [&](std::int32_t child, double distance) {
      offsets[axis] = distance > 0.0 ? std::max(kept, distance * distance) : kept;
      double to_box = offsets[0];
      for (std::size_t k = 1; k < kDimension; ++k) to_box += offsets[k];
      if (to_box <= search.bound()) {
        descend(child, offsets, search);
      } else {
        search.pruned(to_box);
      }
    };
    if (to_left < to_right) {
      visit(index + 1, to_left);
      visit(node.right, to_right);
    } else {
      visit(node.right, to_right);
      visit(index + 1, to_left);
    }
    offsets[axis] = kept;
  }

  std::int32_t build(std::int32_t begin, std::int32_t end) {
    const auto number = static_cast<std::int32_t>(nodes_.size());
    nodes_.emplace_back();
    const auto first = entries_.begin() + begin;
    const auto last = entries_.begin() + end;
    const auto make_leaf = [&](std::int32_t axis) {
      // The order within a leaf then does not depend on how the standard library partitions.
      std::sort(first, last, [](const Entry& a, const Entry& b) { return a.index < b.index; });
      nodes_.back() = {.axis = axis, .begin = begin, .end = end};
      return number;
    };
    if (end - begin <= kLeafSize) return make_leaf(kLeaf);
    Point low = first->point;
    Point high = first->point;
    for (auto it = first; it != last; ++it) {
      low = low.cwiseMin(it->point);
      high = high.cwiseMax(it->point);
    }
    if (low == high) return make_leaf(kOnePlace);
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::int32_t middle = begin + (end - begin) / 2;
    const auto split = entries_.begin() + middle;
    std::nth_element(first, split, last, [axis](const Entry& a, const Entry& b) {
      return a.point(axis) < b.point(axis) || (a.point(axis) == b.point(axis) && a.index < b.index);
    });
    double left_end = first->point(axis);
    for (auto it = first; it != split; ++it) left_end = std::max(left_end, it->point(axis));
    const double right_start = split->point(axis);
    build(begin, middle);
    const std::int32_t right = build(middle, end);
    Node& node = nodes_[static_cast<std::size_t>(number)];
    node.left_end = left_end;
    node.right_start = right_start;
    node.axis = axis;
    node.right = right;
    return number;
  }

  std::vector<Entry> entries_{};
  std::vector<Node> nodes_{};
};

}  // namespace loopstone
