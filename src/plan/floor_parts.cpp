#include "plan/floor_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "loopstone/grid/grid_cells.hpp"
#include "plan/plan_cells.hpp"

namespace loopstone {

namespace {

constexpr std::array<Cell, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// Cells that a line goes through, so close that nothing that steps sideways or up and down gets
/// past; of those only what `may` says.
template <typename May>
void draw_barrier(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                  Grid<std::uint8_t>& barriers, May&& may) {
  const GridFrame& frame = barriers.frame();
  const double step_m = 0.2 * frame.resolution;
  const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step_m)));
  for (int i = 0; i <= count; ++i) {
    const Cell cell = frame.cell_of(from + static_cast<double>(i) / count * (to - from));
    if (frame.contains(cell) && may(cell)) barriers[cell] = 1;
  }
}

/// A face, and what nobody saw right behind it: that is no floor.
void draw_wall(const PlanSegment& wall, const Grid<std::int8_t>& cells,
               Grid<std::uint8_t>& barriers) {
  draw_barrier(wall.from, wall.to, barriers, [](Cell) { return true; });
  for (double behind = 0.7; behind * cells.frame().resolution <= kPlanRooms.core_m; behind += 0.7) {
    const Eigen::Vector2d off = behind * cells.frame().resolution * wall.normal();
    draw_barrier(wall.from - off, wall.to - off, barriers,
                 [&](Cell cell) { return !is_free_cell(cells, cell); });
  }
}

class FloorFlood {
 public:
  FloorFlood(const Grid<std::int8_t>& cells, Grid<std::uint8_t> barriers)
      : cells_(cells), barriers_(std::move(barriers)) {
    parts_.part_of = Grid<int>(cells.frame(), FloorParts::kNone);
  }

  FloorParts run() {
    label_free();
    fill_pockets();
    return std::move(parts_);
  }

 private:
  template <typename Open>
  std::vector<Cell> flood(Cell seed, Grid<std::uint8_t>& seen, Open&& is_open) const {
    std::vector<Cell> found{seed};
    seen[seed] = 1;
    for (std::size_t next = 0; next < found.size(); ++next) {
      for (const Cell side : kSides) {
        const Cell cell{found[next].column + side.column, found[next].row + side.row};
        if (!cells_.frame().contains(cell) || seen[cell] != 0 || !is_open(cell)) continue;
        seen[cell] = 1;
        found.push_back(cell);
      }
    }
    return found;
  }

  [[nodiscard]] double area_of(std::size_t count) const {
    return static_cast<double>(count) * cells_.frame().resolution * cells_.frame().resolution;
  }

  void label_free() {
    Grid<std::uint8_t> seen(cells_.frame());
    const auto is_floor = [&](Cell cell) {
      return barriers_[cell] == 0 && is_free_cell(cells_, cell);
    };
    for_each_cell(cells_.frame(), [&](Cell seed) {
      if (seen[seed] != 0 || !is_floor(seed)) return;
      const std::vector<Cell> found = flood(seed, seen, is_floor);
      if (area_of(found.size()) < kPlanRooms.room_least_m2) return;
      const int part = static_cast<int>(parts_.areas_m2.size());
      for (const Cell cell : found) parts_.part_of[cell] = part;
      parts_.areas_m2.push_back(area_of(found.size()));
    });
  }

  /// What is enclosed by walls and one part.
  void fill_pockets() {
    Grid<std::uint8_t> seen(cells_.frame());
    const auto is_pocket = [&](Cell cell) {
      return barriers_[cell] == 0 && parts_.part_of[cell] == FloorParts::kNone;
    };
    std::vector<std::pair<int, std::vector<Cell>>> filled;
    for_each_cell(cells_.frame(), [&](Cell seed) {
      if (seen[seed] != 0 || !is_pocket(seed)) return;
      std::vector<Cell> found = flood(seed, seen, is_pocket);
      if (area_of(found.size()) > kPlanRooms.pocket_most_m2) return;
      std::map<int, int> around;
      for (const Cell cell : found) {
        for (const Cell side : kSides) {
          const Cell next{cell.column + side.column, cell.row + side.row};
          if (!cells_.frame().contains(next)) return;
          const int part = parts_.part_of[next];
          if (part != FloorParts::kNone) ++around[part];
        }
      }
      if (around.empty()) return;
      const auto most =
          std::max_element(around.begin(), around.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
      filled.emplace_back(most->first, std::move(found));
    });
    for (const auto& [part, pocket] : filled) {
      for (const Cell cell : pocket) parts_.part_of[cell] = part;
      parts_.areas_m2[static_cast<std::size_t>(part)] += area_of(pocket.size());
    }
  }

  const Grid<std::int8_t>& cells_;
  Grid<std::uint8_t> barriers_;
  FloorParts parts_{};
};

}  // namespace

int FloorParts::beside(const DoorFace& face, double side) const {
  const GridFrame& frame = part_of.frame();
  for (const double away : {1.6, 2.6, 4.0}) {
    const Cell cell = frame.cell_of(face.middle() + side * away * frame.resolution * face.normal());
    const int part = part_of.value_or(cell, kNone);
    if (part != kNone) return part;
  }
  return kNone;
}

FloorParts part_floor(const Grid<std::int8_t>& cells, std::span<const PlanSegment> segments,
                      std::span<const DoorFace> faces) {
  Grid<std::uint8_t> barriers(cells.frame());
  for (const PlanSegment& segment : segments)
    if (segment.layer != PlanLayer::kMovable) draw_wall(segment, cells, barriers);
  for (const DoorFace& face : faces)
    draw_barrier(face.from, face.to, barriers, [](Cell) { return true; });
  return FloorFlood(cells, std::move(barriers)).run();
}

}  // namespace loopstone
