#include "plan/plan_layers.hpp"

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/union_find.hpp"
#include "loopstone/geometry/angle.hpp"
#include "plan/plan_cells.hpp"
#include "plan/plan_numbers.hpp"

namespace loopstone {

namespace {

/// Which cells stand free in the room: pieces of what is not free, and how large each is.
class Islands {
 public:
  explicit Islands(const Grid<std::int8_t>& cells)
      : cells_(cells), piece_of_(cells.frame(), kNone) {
    const GridFrame& frame = cells.frame();
    for (int row = 0; row < frame.rows; ++row) {
      for (int column = 0; column < frame.columns; ++column) {
        const Cell cell{column, row};
        if (!is_free_cell(cells, cell) && piece_of_[cell] == kNone) flood(cell);
      }
    }
  }

  /// Whether what is behind this piece of surface stands free and is small.
  [[nodiscard]] bool is_island(const PlanSegment& segment) const {
    const double resolution = cells_.frame().resolution;
    for (const double depth : {0.0, 0.6, 1.2}) {
      const Cell cell =
          cells_.frame().cell_of(segment.middle() - depth * resolution * segment.normal());
      const int piece = piece_of_.value_or(cell, kNone);
      if (piece != kNone) return small_[static_cast<std::size_t>(piece)];
    }
    return false;
  }

 private:
  static constexpr int kNone = -1;

  void flood(Cell seed) {
    const int piece = static_cast<int>(small_.size());
    std::vector<Cell> open{seed};
    piece_of_[seed] = piece;
    Cell low = seed;
    Cell high = seed;
    while (!open.empty()) {
      const Cell at = open.back();
      open.pop_back();
      low = {std::min(low.column, at.column), std::min(low.row, at.row)};
      high = {std::max(high.column, at.column), std::max(high.row, at.row)};
      for (int r = -1; r <= 1; ++r) {
        for (int c = -1; c <= 1; ++c) {
          const Cell next{at.column + c, at.row + r};
          if (!cells_.frame().contains(next) || piece_of_[next] != kNone ||
              is_free_cell(cells_, next)) {
            continue;
          }
          piece_of_[next] = piece;
          open.push_back(next);
        }
      }
    }
    const GridFrame& frame = cells_.frame();
    const bool at_border = low.column == 0 || low.row == 0 || high.column == frame.columns - 1 ||
                           high.row == frame.rows - 1;
    const double size_m = frame.resolution * std::sqrt(std::pow(high.column - low.column + 1, 2) +
                                                       std::pow(high.row - low.row + 1, 2));
    small_.push_back(!at_border && size_m <= kPlanRooms.island_m);
  }

  const Grid<std::int8_t>& cells_;
  Grid<int> piece_of_;
  std::vector<bool> small_{};
};

/// What is of the same surface, as far as a line tells.
bool in_one_plane(const PlanSegment& a, const PlanSegment& b, double plane_m) {
  if (a.direction().dot(b.direction()) < std::cos(radians(1.5))) return false;
  const double off = std::abs((b.middle() - a.middle()).dot(a.normal()));
  return off <= plane_m + 2.0 * hypotenuse(a.sigma_across_m, b.sigma_across_m);
}

/// Of two faces as far apart as a wall is thick, turned from each other: the length along which
/// they are back to back.
double back_to_back_m(const PlanSegment& a, const PlanSegment& b) {
  if (a.direction().dot(b.direction()) > -0.998) return 0.0;
  const double depth_m = -(b.middle() - a.middle()).dot(a.normal());
  if (depth_m < 0.06 || depth_m > kPlanRooms.wall_usual_m) return 0.0;
  const double from = (b.to - a.from).dot(a.direction());
  const double to = (b.from - a.from).dot(a.direction());
  return std::max(0.0, std::min(to, a.length_m()) - std::max(from, 0.0));
}

/// Whether something stands between two points that runs across.
bool is_crossed(const std::vector<PlanSegment>& segments, const Eigen::Vector2d& from,
                const Eigen::Vector2d& to) {
  const Eigen::Vector2d u = (to - from).normalized();
  const Eigen::Vector2d normal(-u.y(), u.x());
  const double length_m = (to - from).norm();
  return std::any_of(segments.begin(), segments.end(), [&](const PlanSegment& segment) {
    const double a = (segment.from - from).dot(normal);
    const double b = (segment.to - from).dot(normal);
    if (std::max(a, b) < 0.04 || std::min(a, b) > -0.04 || std::abs(a - b) < 0.1) return false;
    const Eigen::Vector2d at = segment.from + a / (a - b) * (segment.to - segment.from);
    const double t = (at - from).dot(u);
    return t > 0.0 && t < length_m;
  });
}

/// The lengths of surfaces in one plane, where nothing but a door or a thing lies between them.
class PlaneSupport {
 public:
  PlaneSupport(const Grid<std::int8_t>& cells, const std::vector<PlanSegment>& segments,
               const std::vector<bool>& left_out, double plane_m)
      : parents_(segments.size()), length_m_(segments.size(), 0.0) {
    std::iota(parents_.begin(), parents_.end(), 0);
    for (std::size_t a = 0; a < segments.size(); ++a) {
      for (std::size_t b = 0; b < segments.size(); ++b) {
        if (a == b || left_out[a] || left_out[b] ||
            !in_one_plane(segments[a], segments[b], plane_m))
          continue;
        const double gap_m = (segments[b].from - segments[a].to).dot(segments[a].direction());
        if (gap_m > kPlanRooms.hidden_most_m || gap_m < -0.1) continue;
        if (gap_m > kPlan.gap_m) {
          const double free = free_share(cells, segments[a].to, segments[b].from);
          if ((free > 0.15 && free < 0.6) || is_crossed(segments, segments[a].to, segments[b].from))
            continue;
        }
        join(parents_, static_cast<int>(a), static_cast<int>(b));
      }
      for (std::size_t b = 0; b < a; ++b) {
        if (!left_out[a] && !left_out[b] && back_to_back_m(segments[a], segments[b]) >= 0.4)
          join(parents_, static_cast<int>(a), static_cast<int>(b));
      }
    }
    for (std::size_t i = 0; i < segments.size(); ++i)
      if (!left_out[i]) length_m_[root(i)] += segments[i].length_m();
  }

  [[nodiscard]] double of(std::size_t i) { return length_m_[root(i)]; }

 private:
  [[nodiscard]] std::size_t root(std::size_t i) {
    return static_cast<std::size_t>(root_of(parents_, static_cast<int>(i)));
  }
  std::vector<int> parents_;
  std::vector<double> length_m_;
};

/// The front of something that stands before a wall: a corner that juts out, from which a short
/// side leads back to where the wall is.
bool is_front(const JoinedSegments& joined, std::size_t i) {
  const auto leads_back = [&](const EndJoint& joint, bool at_to) {
    if (joint.segment < 0 || !joint.convex) return false;
    const auto side = static_cast<std::size_t>(joint.segment);
    const EndJoint& far = at_to ? joined.at_to[side] : joined.at_from[side];
    return far.segment >= 0 && !far.convex && joined.segments[side].length_m() <= 1.0 &&
           joined.segments[side].length_m() > 0.1;
  };
  return leads_back(joined.at_to[i], true) || leads_back(joined.at_from[i], false);
}

bool is_structure(const JoinedSegments& joined, int segment) {
  return segment >= 0 &&
         joined.segments[static_cast<std::size_t>(segment)].layer == PlanLayer::kStructure;
}

/// Jambs and the like: joined to walls on both ends; or on one, round a corner that juts out.
bool completes_walls(const JoinedSegments& joined, std::size_t i) {
  const EndJoint& from = joined.at_from[i];
  const EndJoint& to = joined.at_to[i];
  const bool at_from = is_structure(joined, from.segment);
  const bool at_to = is_structure(joined, to.segment);
  if (at_from && at_to) return true;
  // From a room's corner on, farther than things are deep, and no corner of its own at the end.
  if (joined.segments[i].length_m() >= 0.9 &&
      ((at_from && !from.convex && !to.convex) || (at_to && !to.convex && !from.convex))) {
    return true;
  }
  if (joined.segments[i].length_m() > kPlanRooms.wall_usual_m) return false;
  return (at_from && from.convex) || (at_to && to.convex);
}

/// The other face of a wall that is known to be one.
bool backs_wall(const JoinedSegments& joined, std::size_t i) {
  double sum_m = 0.0;
  for (const PlanSegment& face : joined.segments)
    if (face.layer != PlanLayer::kMovable) sum_m += back_to_back_m(joined.segments[i], face);
  return sum_m >= 0.4 * joined.segments[i].length_m();
}

/// Of the same surface as a wall nearby, and nothing runs across between them.
bool continues_wall(const JoinedSegments& joined, std::size_t i) {
  const PlanSegment& segment = joined.segments[i];
  return std::any_of(joined.segments.begin(), joined.segments.end(), [&](const PlanSegment& wall) {
    if (wall.layer == PlanLayer::kMovable || !in_one_plane(segment, wall, joined.plane_m))
      return false;
    const double ahead_m = (wall.from - segment.to).dot(segment.direction());
    const double behind_m = (segment.from - wall.to).dot(segment.direction());
    if (std::max(ahead_m, behind_m) > kPlanRooms.opening_most_m) return false;
    if (ahead_m > 0.1) return !is_crossed(joined.segments, segment.to, wall.from);
    if (behind_m > 0.1) return !is_crossed(joined.segments, wall.to, segment.from);
    return true;
  });
}

bool is_corner_of_room(const EndJoint& joint) { return joint.segment >= 0 && !joint.convex; }

}  // namespace

void find_structure(const Grid<std::int8_t>& cells, JoinedSegments& joined) {
  const Islands islands(cells);
  std::vector<PlanSegment>& segments = joined.segments;
  std::vector<bool> left_out;
  for (std::size_t i = 0; i < segments.size(); ++i)
    left_out.push_back(segments[i].length_m() < kPlanRooms.support_length_m && is_front(joined, i));
  PlaneSupport support(cells, segments, left_out, joined.plane_m);
  joined.stands_free = left_out;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    segments[i].layer = PlanLayer::kMovable;
    if (left_out[i]) continue;
    // Walls between doors may stand free on a map, too: then others stand in their plane.
    const bool is_island = islands.is_island(segments[i]);
    const bool between_corners =
        !is_island && is_corner_of_room(joined.at_from[i]) && is_corner_of_room(joined.at_to[i]);
    const double needed_m = kPlanRooms.support_length_m * (is_island ? 2.0 : 1.0);
    if (support.of(i) >= needed_m || between_corners)
      segments[i].layer = PlanLayer::kStructure;
    else
      joined.stands_free[i] = is_island;
  }
  complete_structure(joined);
}

void complete_structure(JoinedSegments& joined) {
  std::vector<PlanSegment>& segments = joined.segments;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (joined.stands_free[i] || segments[i].layer != PlanLayer::kMovable) continue;
      if (!backs_wall(joined, i) && !completes_walls(joined, i) && !continues_wall(joined, i))
        continue;
      segments[i].layer = PlanLayer::kStructure;
      changed = true;
    }
  }
}

}  // namespace loopstone
