#include "loopstone/registration/correspondences.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>

#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

namespace {

/// Bounds are computed with a few roundings; by this much they may be off, and are taken lower.
constexpr double kRounding = 1.0 - 1e-12;

template <int kDimension>
double squared_distance(const Eigen::Matrix<double, kDimension, 1>& a,
                        const Eigen::Matrix<double, kDimension, 1>& b) {
  double sum = 0.0;
  for (int k = 0; k < kDimension; ++k) {
    const double d = a(k) - b(k);
    sum += d * d;
  }
  return sum;
}

/// The best point so far, and the least distance of all others.
struct Best {
  std::int32_t index = -1;
  double squared;
  double others = std::numeric_limits<double>::infinity();

  explicit Best(double max_distance_m) : squared(max_distance_m * max_distance_m) {}

  void offer(std::int32_t candidate, double squared_distance) {
    if (candidate == index) return;
    const bool better = squared_distance < squared ||
                        (squared_distance == squared && (index < 0 || candidate < index));
    if (!better) {
      others = std::min(others, squared_distance);
      return;
    }
    if (index >= 0) others = std::min(others, squared);
    squared = squared_distance;
    index = candidate;
  }

  [[nodiscard]] NearestPoint answer(double max_distance_m) const {
    if (index < 0) return {-1, 0.0, max_distance_m};
    return {index, squared, std::sqrt(others) * kRounding};
  }
};

/// Mixes the bits of a number (the finaliser of MurmurHash3).
std::uint64_t mixed(std::uint64_t bits) {
  bits ^= bits >> 33U;
  bits *= 0xff51afd7ed558ccdULL;
  bits ^= bits >> 33U;
  bits *= 0xc4ceb9fe1a85ec53ULL;
  return bits ^ (bits >> 33U);
}

/// Grows with the bearing from 0 to 4, without a transcendental function.
double bearing_order(const Eigen::Vector2d& v) {
  const double sum = std::abs(v.x()) + std::abs(v.y());
  const double share = v.y() / sum;
  if (v.x() < 0.0) return 2.0 - share;
  return v.y() < 0.0 ? 4.0 + share : share;
}

}  // namespace

template <int kDimension>
CellIndex<kDimension>::CellIndex(std::span<const Point> points, double cell_size_m)
    : cell_size_m_(cell_size_m), entry_of_(points.size(), -1) {
  assert(cell_size_m > 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_usable_point(points[i])) {
      entries_.push_back({cell_of(points[i]), points[i], static_cast<std::int32_t>(i)});
    }
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.cell < b.cell || (a.cell == b.cell && a.index < b.index);
  });
  std::size_t slots = 16;
  while (slots < 2 * entries_.size()) slots *= 2;
  slots_.resize(slots);
  low_.fill(std::numeric_limits<std::int64_t>::max());
  high_.fill(std::numeric_limits<std::int64_t>::min());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    entry_of_[static_cast<std::size_t>(entry.index)] = static_cast<std::int32_t>(i);
    for (std::size_t k = 0; k < kDimension; ++k) {
      low_[k] = std::min(low_[k], entry.cell[k]);
      high_[k] = std::max(high_[k], entry.cell[k]);
    }
    Slot& slot = slots_[slot_of(entry.cell)];
    if (slot.begin == slot.end) slot.begin = static_cast<std::int32_t>(i);
    slot.end = static_cast<std::int32_t>(i) + 1;
  }
}

template <int kDimension>
typename CellIndex<kDimension>::Cell CellIndex<kDimension>::cell_of(const Point& point) const {
  // Far outside, the numbers of cells saturate: the search stays exact, only slow.
  constexpr double kMost = 1e15;
  Cell cell;
  for (int k = 0; k < kDimension; ++k) {
    cell[static_cast<std::size_t>(k)] =
        static_cast<std::int64_t>(std::clamp(std::floor(point(k) / cell_size_m_), -kMost, kMost));
  }
  return cell;
}

template <int kDimension>
std::size_t CellIndex<kDimension>::slot_of(const Cell& cell) const {
  std::uint64_t hash = 0;
  for (const std::int64_t number : cell) {
    hash = mixed(hash ^ static_cast<std::uint64_t>(number));
  }
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>(hash) & mask;
  while (slots_[slot].begin != slots_[slot].end &&
         entries_[static_cast<std::size_t>(slots_[slot].begin)].cell != cell) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

namespace {

/// All cells of a ring around a centre, within a box: the last axis is walked in full where another
/// one is at its end, else only at both ends.
template <typename Cell, typename Visitor>
void visit_shell(const Cell& centre, std::int64_t ring, const Cell& from, const Cell& to,
                 const Visitor& visit) {
  constexpr std::size_t kLast = std::tuple_size_v<Cell> - 1;
  Cell cell = from;
  while (true) {
    bool on_shell = false;
    for (std::size_t k = 0; k < kLast; ++k) {
      on_shell = on_shell || cell[k] == centre[k] - ring || cell[k] == centre[k] + ring;
    }
    if (on_shell) {
      for (cell[kLast] = from[kLast]; cell[kLast] <= to[kLast]; ++cell[kLast]) visit(cell);
    } else {
      for (const std::int64_t end : {centre[kLast] - ring, centre[kLast] + ring}) {
        if (end < from[kLast] || end > to[kLast]) continue;
        cell[kLast] = end;
        visit(cell);
        if (ring == 0) break;
      }
    }
    std::size_t axis = 0;
    for (; axis < kLast; ++axis) {
      if (++cell[axis] <= to[axis]) break;
      cell[axis] = from[axis];
    }
    if (axis == kLast) break;
  }
}

}  // namespace

template <int kDimension>
NearestPoint CellIndex<kDimension>::nearest_point(const Point& query, double max_distance_m,
                                                  std::int32_t hint) const {
  Best best(max_distance_m);
  if (entries_.empty() || !is_usable_point(query)) return best.answer(max_distance_m);
  if (hint >= 0) {
    const std::int32_t entry = entry_of_[static_cast<std::size_t>(hint)];
    const double squared =
        squared_distance<kDimension>(entries_[static_cast<std::size_t>(entry)].point, query);
    if (squared <= best.squared) best.offer(hint, squared);
  }
  const Cell centre = cell_of(query);
  // How far the query is from the nearest side of its own cell; from ring r it is r cells more.
  double to_side = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kDimension; ++k) {
    const double within =
        query(k) - cell_size_m_ * static_cast<double>(centre[static_cast<std::size_t>(k)]);
    to_side = std::min({to_side, within, cell_size_m_ - within});
  }
  to_side = std::max(to_side, 0.0);
  // Rings that lie wholly outside the box of the points are skipped.
  std::int64_t ring = 0;
  std::int64_t last_ring = 0;
  for (std::size_t k = 0; k < kDimension; ++k) {
    ring = std::max({ring, low_[k] - centre[k], centre[k] - high_[k]});
    last_ring = std::max({last_ring, high_[k] - centre[k], centre[k] - low_[k]});
  }
  const auto look_into = [&](const Cell& cell) {
    const Slot slot = slots_[slot_of(cell)];
    for (std::int32_t i = slot.begin; i < slot.end; ++i) {
      const Entry& entry = entries_[static_cast<std::size_t>(i)];
      best.offer(entry.index, squared_distance<kDimension>(entry.point, query));
    }
  };
  for (; ring <= last_ring; ++ring) {
    const double inner =
        ring == 0 ? 0.0 : (static_cast<double>(ring - 1) * cell_size_m_ + to_side) * (1.0 - 1e-9);
    if (inner * inner > best.squared) {
      best.others = std::min(best.others, inner * inner);
      break;
    }
    Cell from;
    Cell to;
    for (std::size_t k = 0; k < kDimension; ++k) {
      from[k] = std::max(centre[k] - ring, low_[k]);
      to[k] = std::min(centre[k] + ring, high_[k]);
    }
    visit_shell(centre, ring, from, to, look_into);
  }
  return best.answer(max_distance_m);
}

template class CellIndex<2>;
template class CellIndex<3>;

BearingIndex::BearingIndex(std::span<const Eigen::Vector2d> points)
    : points_(points.begin(), points.end()) {
  entries_.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_usable_point(points[i])) continue;
    const auto index = static_cast<std::int32_t>(i);
    const double range = points[i].norm();
    if (range > 0.0) {
      entries_.push_back({points[i], points[i] / range, bearing_order(points[i]), index});
    } else {
      at_origin_.push_back({points[i], Eigen::Vector2d::Zero(), 0.0, index});
    }
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.order < b.order || (a.order == b.order && a.index < b.index);
  });
}

NearestPoint BearingIndex::nearest_point(const Eigen::Vector2d& query, double max_distance_m,
                                         std::int32_t hint) const {
  Best best(max_distance_m);
  if (!is_usable_point(query)) return best.answer(max_distance_m);
  if (hint >= 0) {
    const double squared = squared_distance<2>(points_[static_cast<std::size_t>(hint)], query);
    if (squared <= best.squared) best.offer(hint, squared);
  }
  for (const Entry& entry : at_origin_) {
    best.offer(entry.index, squared_distance<2>(entry.point, query));
  }
  const double squared_range = query.squaredNorm();
  // The least squared distance of the query to points on this bearing, or farther away from its
  // own.
  const auto bound = [&](const Entry& entry) {
    if (entry.direction.dot(query) <= 0.0) return squared_range * kRounding;
    const double across = entry.direction.x() * query.y() - entry.direction.y() * query.x();
    // The cross product loses digits to cancellation, at most this much.
    const double kept = std::abs(across) - 1e-15 * std::sqrt(squared_range);
    return kept > 0.0 ? kept * kept * kRounding : 0.0;
  };
  const std::size_t count = entries_.size();
  if (count == 0) return best.answer(max_distance_m);
  const double order = squared_range > 0.0 ? bearing_order(query) : 0.0;
  std::size_t after = static_cast<std::size_t>(
      std::lower_bound(entries_.begin(), entries_.end(), order,
                       [](const Entry& entry, double value) { return entry.order < value; }) -
      entries_.begin());
  std::size_t before = after;  // both walk round the circle
  std::size_t seen = 0;
  bool more_after = true;
  bool more_before = true;
  while (seen < count && (more_after || more_before)) {
    if (more_after) {
      const Entry& entry = entries_[after == count ? 0 : after];
      const double least = bound(entry);
      more_after = least <= best.squared;
      if (more_after) {
        best.offer(entry.index, squared_distance<2>(entry.point, query));
        after = (after == count ? 0 : after) + 1;
        ++seen;
      } else {
        best.others = std::min(best.others, least);
      }
    }
    if (more_before && seen < count) {
      const std::size_t place = before == 0 ? count - 1 : before - 1;
      const Entry& entry = entries_[place];
      const double least = bound(entry);
      more_before = least <= best.squared;
      if (more_before) {
        best.offer(entry.index, squared_distance<2>(entry.point, query));
        before = place;
        ++seen;
      } else {
        best.others = std::min(best.others, least);
      }
    }
  }
  return best.answer(max_distance_m);
}

}  // namespace loopstone
