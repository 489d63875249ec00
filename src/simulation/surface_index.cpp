#include "loopstone/simulation/surface_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Surfaces also belong to cells that they miss by less, so that rounding at a cell's border loses
/// none [m].
constexpr double kBorder = 1e-6;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Separating axis test of a segment and an axis-aligned square.
bool touches(const Segment& segment, const Eigen::Vector2d& centre, double half_side) {
  const Eigen::Vector2d along = segment.to - segment.from;
  const Eigen::Vector2d middle = 0.5 * (segment.from + segment.to) - centre;
  if (std::abs(middle.x()) > half_side + 0.5 * std::abs(along.x())) return false;
  if (std::abs(middle.y()) > half_side + 0.5 * std::abs(along.y())) return false;
  return std::abs(cross(along, middle)) <=
         half_side * (std::abs(along.x()) + std::abs(along.y())) + 1e-12;
}

bool touches(const Circle& circle, const Eigen::Vector2d& centre, double half_side) {
  const Eigen::Vector2d offset = (circle.centre - centre).cwiseAbs();
  const Eigen::Vector2d near = (offset.array() - half_side).max(0.0);
  const Eigen::Vector2d far = offset.array() + half_side;
  return near.norm() <= circle.radius_m && far.norm() >= circle.radius_m;
}

/// When a ray crosses the borders of cells along one axis.
struct AxisWalk {
  int step = 0;
  double next = kInfinity;   ///< range at which it leaves the current cell
  double delta = kInfinity;  ///< range between borders
};

AxisWalk axis_walk(double origin, double direction, int cell, double frame_origin,
                   double resolution) {
  if (direction > 0.0) {
    const double border = frame_origin + (cell + 1) * resolution;
    return {1, (border - origin) / direction, resolution / direction};
  }
  if (direction < 0.0) {
    const double border = frame_origin + cell * resolution;
    return {-1, (border - origin) / direction, -resolution / direction};
  }
  return {};
}

/// The part of a ray within a rectangle; from > to when it misses.
struct Span {
  double from = 0.0;
  double to = kInfinity;
};

Span clip(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
          const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  Span span;
  for (int axis = 0; axis < 2; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < low[axis] || origin[axis] > high[axis]) return {1.0, 0.0};
      continue;
    }
    double near = (low[axis] - origin[axis]) / direction[axis];
    double far = (high[axis] - origin[axis]) / direction[axis];
    if (near > far) std::swap(near, far);
    span.from = std::max(span.from, near);
    span.to = std::min(span.to, far);
  }
  return span;
}

}  // namespace

double range_to(const Segment& segment, const Eigen::Vector2d& origin,
                const Eigen::Vector2d& direction) {
  // origin + t direction = from + u along
  const Eigen::Vector2d along = segment.to - segment.from;
  const double determinant = cross(direction, along);
  if (determinant == 0.0) return kInfinity;
  const Eigen::Vector2d offset = segment.from - origin;
  const double u = cross(offset, direction) / determinant;
  // The ends belong to a segment with a little to spare, so that no ray slips through a corner.
  if (!(u >= -1e-9 && u <= 1.0 + 1e-9)) return kInfinity;
  const double t = cross(offset, along) / determinant;
  return t >= 0.0 ? t : kInfinity;
}

double range_to(const Circle& circle, const Eigen::Vector2d& origin,
                const Eigen::Vector2d& direction) {
  const Eigen::Vector2d offset = circle.centre - origin;
  const double along = offset.dot(direction);
  const double aside = cross(direction, offset);
  const double squared_half_chord = circle.radius_m * circle.radius_m - aside * aside;
  if (squared_half_chord < 0.0) return kInfinity;
  const double half_chord = std::sqrt(squared_half_chord);
  if (along - half_chord >= 0.0) return along - half_chord;
  return along + half_chord >= 0.0 ? along + half_chord : kInfinity;
}

SurfaceIndex::SurfaceIndex(const FloorPlan& plan, double cell_m)
    : segments_(flat_surfaces(plan)), circles_(plan.circles) {
  const Extent extent = extent_of(plan);
  frame_ = frame_covering(extent.low, extent.high, cell_m, cell_m);

  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  // cell, surface
  const auto enter = [&](const auto& surface, const Eigen::Vector2d& low,
                         const Eigen::Vector2d& high, std::size_t id) {
    const Cell first = frame_.cell_of(low.array() - kBorder);
    const Cell last = frame_.cell_of(high.array() + kBorder);
    for (int row = first.row; row <= last.row; ++row) {
      for (int column = first.column; column <= last.column; ++column) {
        const Cell cell{column, row};
        if (frame_.contains(cell) &&
            touches(surface, frame_.centre_of(cell), 0.5 * frame_.resolution + kBorder)) {
          entries.emplace_back(static_cast<std::uint32_t>(frame_.index_of(cell)),
                               static_cast<std::uint32_t>(id));
        }
      }
    }
  };
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const Segment& s = segments_[i];
    enter(s, s.from.cwiseMin(s.to), s.from.cwiseMax(s.to), i);
  }
  for (std::size_t i = 0; i < circles_.size(); ++i) {
    const Circle& c = circles_[i];
    enter(c, c.centre.array() - c.radius_m, c.centre.array() + c.radius_m, segments_.size() + i);
  }
  std::sort(entries.begin(), entries.end());
  first_.assign(frame_.cell_count() + 1, 0);
  surfaces_.reserve(entries.size());
  for (const auto& [cell, surface] : entries) {
    ++first_[cell + 1];
    surfaces_.push_back(surface);
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
}

void SurfaceIndex::for_each_in(Cell cell, auto&& visit) const {
  const std::size_t index = frame_.index_of(cell);
  for (std::uint32_t i = first_[index]; i < first_[index + 1]; ++i) {
    const std::uint32_t surface = surfaces_[i];
    if (surface < segments_.size()) {
      visit(segments_[surface]);
    } else {
      visit(circles_[surface - segments_.size()]);
    }
  }
}

void SurfaceIndex::walk(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                        double max_range_m, auto&& visit) const {
  const Eigen::Vector2d high =
      frame_.origin + frame_.resolution * Eigen::Vector2d(frame_.columns, frame_.rows);
  const Span span = clip(origin, direction, frame_.origin, high);
  if (span.from > span.to || span.from > max_range_m) return;
  Cell cell = frame_.cell_of(origin + span.from * direction);
  cell.column = std::clamp(cell.column, 0, frame_.columns - 1);
  cell.row = std::clamp(cell.row, 0, frame_.rows - 1);
  AxisWalk x =
      axis_walk(origin.x(), direction.x(), cell.column, frame_.origin.x(), frame_.resolution);
  AxisWalk y = axis_walk(origin.y(), direction.y(), cell.row, frame_.origin.y(), frame_.resolution);
  while (frame_.contains(cell)) {
    const double nearest = visit(cell);
    const double leaves_at = std::min(x.next, y.next);
    // Whatever lies in later cells is farther than the border to them, but for rounding.
    if (nearest <= leaves_at - kBorder || leaves_at > max_range_m) break;
    if (x.next <= y.next) {
      cell.column += x.step;
      x.next += x.delta;
    } else {
      cell.row += y.step;
      y.next += y.delta;
    }
  }
}

double SurfaceIndex::cast(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                          double max_range_m) const {
  double nearest = kInfinity;
  walk(origin, direction, max_range_m, [&](Cell cell) {
    for_each_in(cell, [&](const auto& surface) {
      nearest = std::min(nearest, range_to(surface, origin, direction));
    });
    return nearest;
  });
  return nearest <= max_range_m ? nearest : kInfinity;
}

SurfaceHit SurfaceIndex::hit(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                             double max_range_m) const {
  SurfaceHit nearest;
  walk(origin, direction, max_range_m, [&](Cell cell) {
    const std::size_t index = frame_.index_of(cell);
    for (std::uint32_t i = first_[index]; i < first_[index + 1]; ++i) {
      const double range = range_to_surface(surfaces_[i], origin, direction);
      if (range < nearest.range_m) nearest = {range, surfaces_[i]};
    }
    return nearest.range_m;
  });
  return nearest.range_m <= max_range_m ? nearest : SurfaceHit{};
}

double SurfaceIndex::range_to_surface(std::uint32_t surface, const Eigen::Vector2d& origin,
                                      const Eigen::Vector2d& direction) const {
  return surface < segments_.size()
             ? range_to(segments_[surface], origin, direction)
             : range_to(circles_[surface - segments_.size()], origin, direction);
}

double SurfaceIndex::distance(const Eigen::Vector2d& point, double limit_m) const {
  double nearest = limit_m;
  const Cell low = frame_.cell_of(point.array() - limit_m);
  const Cell high = frame_.cell_of(point.array() + limit_m);
  for (int row = std::max(0, low.row); row <= std::min(frame_.rows - 1, high.row); ++row) {
    for (int column = std::max(0, low.column); column <= std::min(frame_.columns - 1, high.column);
         ++column) {
      for_each_in({column, row}, [&](const auto& surface) {
        nearest = std::min(nearest, distance_to(surface, point));
      });
    }
  }
  return nearest;
}

}  // namespace loopstone
