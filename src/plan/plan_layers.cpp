#include "plan/plan_layers.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
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
    small_.push_back(!at_border && size_m <= kPlan.island_m);
  }

  const Grid<std::int8_t>& cells_;
  Grid<int> piece_of_;
  std::vector<bool> small_{};
};

bool in_one_plane(const PlanSegment& a, const PlanSegment& b) {
  if (a.direction().dot(b.direction()) < std::cos(radians(1.5))) return false;
  const double off = (b.middle() - a.middle()).dot(a.normal());
  return std::abs(off) <= 0.02 + 2.0 * hypotenuse(a.sigma_across_m, b.sigma_across_m);
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
  if (joined.segments[i].length_m() > kPlan.jamb_m) return false;
  return (at_from && from.convex && to.segment < 0) || (at_to && to.convex && from.segment < 0);
}

bool is_corner_of_room(const EndJoint& joint) { return joint.segment >= 0 && !joint.convex; }

}  // namespace

void find_structure(const Grid<std::int8_t>& cells, JoinedSegments& joined) {
  const Islands islands(cells);
  std::vector<PlanSegment>& segments = joined.segments;
  std::vector<bool> free_standing;
  for (const PlanSegment& segment : segments) free_standing.push_back(islands.is_island(segment));
  for (std::size_t i = 0; i < segments.size(); ++i) {
    segments[i].layer = PlanLayer::kMovable;
    if (free_standing[i]) continue;
    double support_m = 0.0;
    for (std::size_t k = 0; k < segments.size(); ++k)
      if (!free_standing[k] && in_one_plane(segments[i], segments[k]))
        support_m += segments[k].length_m();
    const bool between_corners =
        is_corner_of_room(joined.at_from[i]) && is_corner_of_room(joined.at_to[i]);
    if (support_m >= kPlan.support_length_m || between_corners)
      segments[i].layer = PlanLayer::kStructure;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (free_standing[i] || segments[i].layer == PlanLayer::kStructure) continue;
      if (!completes_walls(joined, i)) continue;
      segments[i].layer = PlanLayer::kStructure;
      changed = true;
    }
  }
}

}  // namespace loopstone
