#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/registration/point_index.hpp"

namespace loopstone {

// Two more ways to the nearest point, beside the k-d tree of PointIndex. Both give the same answers
// as it does, to the bit: the nearest point, of equally near ones the one with the lowest number.

/// Points in hashed cells. Looks into the query's cell and then into rings of cells around it, so
/// it is quick when the nearest point is about a cell away, and slow when there is none for many
/// cells.
/// Cost: O(points) to build; a query O((distance / cell)^kDimension).
template <int kDimension>
class CellIndex {
 public:
  using Point = Eigen::Matrix<double, kDimension, 1>;

  /// \param cell_size_m  > 0, best about twice the spacing of the points
  CellIndex(std::span<const Point> points, double cell_size_m);

  [[nodiscard]] NearestPoint nearest_point(const Point& query, double max_distance_m,
                                           std::int32_t hint = -1) const;

 private:
  using Cell = std::array<std::int64_t, kDimension>;
  struct Entry {
    Cell cell;
    Point point;
    std::int32_t index;
  };
  struct Slot {
    std::int32_t begin = 0;
    std::int32_t end = 0;  ///< begin == end: empty
  };

  [[nodiscard]] Cell cell_of(const Point& point) const;
  [[nodiscard]] std::size_t slot_of(const Cell& cell) const;

  double cell_size_m_;
  std::vector<Entry> entries_{};          ///< by cell
  std::vector<Slot> slots_{};             ///< open addressing, a power of two
  std::vector<std::int32_t> entry_of_{};  ///< of a point's number; -1: not finite
  Cell low_{};
  Cell high_{};
};

extern template class CellIndex<2>;
extern template class CellIndex<3>;

/// Points of a scan in the order of their bearings, seen from the origin of their frame. A query
/// starts at its own bearing and walks both ways; a side is done when the ray of its next bearing
/// passes the query at a greater distance than the best point, for every further point lies behind
/// that ray. Always exact; quick when few points share a bearing, as in one scan, and when the
/// query comes from nearby.
/// Cost: O(points log points) to build; a query O(log points + bearings within reach).
/// Source: Censi 2008, "An ICP variant using a point-to-line metric", section IV (without the jump
/// tables).
class BearingIndex {
 public:
  explicit BearingIndex(std::span<const Eigen::Vector2d> points);

  [[nodiscard]] NearestPoint nearest_point(const Eigen::Vector2d& query, double max_distance_m,
                                           std::int32_t hint = -1) const;

 private:
  struct Entry {
    Eigen::Vector2d point;
    Eigen::Vector2d direction;  ///< unit
    double order;               ///< grows with the bearing
    std::int32_t index;
  };
  std::vector<Entry> entries_{};
  std::vector<Entry> at_origin_{};  ///< points without a bearing
  std::vector<Eigen::Vector2d> points_{};
};

}  // namespace loopstone
