#include "registration/lattice_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// Blocks of a level are split into four by four of the next but one below.
constexpr int kLevelsAtOnce = 2;
static_assert(kTileSide == 1 << kLevelsAtOnce);

/// The coarsest level worth starting with: the window in no more blocks than are read at once.
int top_level_for(const MaxPyramid& target, int half_cells) {
  int level = 0;
  while (level + kLevelsAtOnce < target.level_count() && ((2 * half_cells) >> level) >= kTileSide)
    level += kLevelsAtOnce;
  return level;
}

/// The points in another order: each part of them is a sample of all.
std::vector<Eigen::Vector2d> dealt_out(std::span<const Eigen::Vector2d> points, std::size_t parts) {
  std::vector<Eigen::Vector2d> dealt;
  dealt.reserve(points.size());
  for (std::size_t first = 0; first < parts; ++first) {
    for (std::size_t i = first; i < points.size(); i += parts) dealt.push_back(points[i]);
  }
  return dealt;
}

/// Counted from the area's corner; what no shift brings onto the grid lies on the area's edge.
void move_into(const CellArea& area, CellList& cells) {
  for (auto& column : cells.columns)
    column = std::clamp(column, area.first_column, area.first_column + area.columns - 1) -
             area.first_column;
  for (auto& row : cells.rows)
    row = std::clamp(row, area.first_row, area.first_row + area.rows - 1) - area.first_row;
}

/// From one heading to the next no point moves by more than a cell: so many cells more on every
/// side of a block serve as many headings, less one for rounding.
int margin_for(int top_level) { return top_level >= 4 ? (1 << top_level) / 4 : 0; }

}  // namespace

LatticeSearch::LatticeSearch(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                             const SearchWindow& window)
    : lattice_(make_search_lattice(source, target.frame(), window)),
      frame_(target.frame()),
      points_(source.size()),
      top_level_(top_level_for(target, lattice_.half_cells)),
      group_half_(std::max(margin_for(top_level_) - 1, 0)),
      margin_(margin_for(top_level_)),
      area_(cell_area(frame_, lattice_.half_cells + margin_, 1 << top_level_)),
      arms_(arms_of(dealt_out(source, kParts), lattice_)),
      cells_(lattice_.headings.size()) {
  for (int level = 0; level <= top_level_; level += kLevelsAtOnce)
    levels_.emplace_back(target.level(level), area_);
}

const CellList& LatticeSearch::cells_of(int heading) {
  CellList& cells = cells_[static_cast<std::size_t>(heading)];
  if (cells.size() == 0) {
    cells = cells_at(arms_, frame_, lattice_, static_cast<std::size_t>(heading));
    move_into(area_, cells);
  }
  return cells;
}

/// Of the headings that a block of the top level stands for.
int LatticeSearch::last_of_group(int heading) const {
  return std::min(heading + 2 * group_half_, static_cast<int>(cells_.size()) - 1);
}

SearchResult LatticeSearch::best(double min_score, const std::optional<ExcludedPoses>& excluded) {
  // The least sum that still counts, less one: what a sum has to beat.
  best_ = {};
  best_.bound = least_sum(min_score, points_) - 1;
  found_ = false;
  excluded_ = excluded;
  evaluations_ = 0;
  if (!top_floor_ || best_.bound < *top_floor_) bound_window();
  descend(top_blocks_, top_level_);
  SearchResult result;
  result.found = found_;
  result.evaluations = evaluations_;
  if (found_) {
    result.target_T_source =
        lattice_.pose_at(static_cast<std::size_t>(best_.heading), best_.column, best_.row);
    result.score = score_of(best_.bound, points_);
  }
  return result;
}

/// The whole window in blocks of the top level, those that may win.
void LatticeSearch::bound_window() {
  top_blocks_.clear();
  top_floor_ = best_.bound;
  const int side = 1 << top_level_;
  const int count = 2 * lattice_.half_cells / side + 1;
  Block parent;
  for (std::size_t part = 0; part + 1 < kParts; ++part)
    parent.rest[part] = static_cast<std::int32_t>(points_ - part_end(part)) * kSurface;
  const int headings = static_cast<int>(cells_.size());
  for (int heading = 0; heading < headings; heading = last_of_group(heading) + 1) {
    parent.heading = heading;
    for (int line = 0; line < count; line += kTileSide) {
      for (int first = 0; first < count; first += kTileSide) {
        parent.column = first * side - lattice_.half_cells;
        parent.row = line * side - lattice_.half_cells;
        bound_tile(parent, std::min(kTileSide, count - first), std::min(kTileSide, count - line));
      }
    }
  }
  std::sort(top_blocks_.begin(), top_blocks_.end(),
            [](const Block& a, const Block& b) { return is_more_promising(a, b); });
}

/// Of the blocks of a tile of the top level, for all headings of a group at once.
void LatticeSearch::bound_tile(const Block& parent, int columns, int rows) {
  const int side = 1 << top_level_;
  if (group_half_ == 0) {
    add_children(levels_.back(), parent, columns, rows, side, top_blocks_);
    return;
  }
  const CellList& cells =
      cells_of(std::min(parent.heading + group_half_, static_cast<int>(cells_.size()) - 1));
  evaluations_ += static_cast<std::int64_t>(columns) * rows;
  std::array<TileSums, kParts> sums{};
  std::size_t begin = 0;
  for (std::size_t part = 0; part < kParts; ++part) {
    if (part > 0) sums[part] = sums[part - 1];
    levels_.back().add_widened(cells, begin, part_end(part), parent.column + area_.half_cells,
                               parent.row + area_.half_cells, margin_, sums[part]);
    begin = part_end(part);
  }
  add_winners(sums, parent, columns, rows, side, top_blocks_);
}

/// Of the blocks of a tile that begins where the parent does, those that may win. No part of the
/// points has a larger sum in a block than in the parent.
void LatticeSearch::add_children(TileReader& level, const Block& parent, int columns, int rows,
                                 int side, std::vector<Block>& children) {
  const CellList& cells = cells_of(parent.heading);
  const int column = parent.column + area_.half_cells;
  const int row = parent.row + area_.half_cells;
  evaluations_ += static_cast<std::int64_t>(columns) * rows;
  std::array<TileSums, kParts> sums{};  // up to each part
  std::size_t begin = 0;
  for (std::size_t part = 0; part < kParts; ++part) {
    if (part > 0) sums[part] = sums[part - 1];
    level.add(cells, begin, part_end(part), column, row, sums[part]);
    begin = part_end(part);
    if (part + 1 == kParts) break;
    const std::int32_t needed = best_.bound - parent.rest[part];
    if (*std::max_element(sums[part].begin(), sums[part].end()) < needed) return;
  }
  add_winners(sums, parent, columns, rows, side, children);
}

void LatticeSearch::add_winners(const std::array<TileSums, kParts>& sums, const Block& parent,
                                int columns, int rows, int side,
                                std::vector<Block>& children) const {
  for (int line = 0; line < rows; ++line) {
    for (int lane = 0; lane < columns; ++lane) {
      const auto at = static_cast<std::size_t>(line * kTileSide + lane);
      Block block;
      block.bound = sums.back()[at];
      block.heading = parent.heading;
      block.column = parent.column + lane * side;
      block.row = parent.row + line * side;
      if (!may_win(block)) continue;
      for (std::size_t part = 0; part + 1 < kParts; ++part)
        block.rest[part] = block.bound - sums[part][at];
      children.push_back(block);
    }
  }
}

/// Looks into every block that may beat the best leaf, the most promising first.
/// \param blocks  sorted
void LatticeSearch::descend(std::vector<Block>& blocks, int level) {
  std::vector<Block> children;
  for (const Block& block : blocks) {
    if (!may_win(block)) {
      if (block.bound < best_.bound) break;
      continue;
    }
    if (level == 0) {
      if (is_excluded(block.heading, block.column, block.row)) continue;
      best_ = block;
      found_ = true;
      continue;
    }
    children.clear();
    if (level == top_level_) {
      split_top(block, children);
    } else {
      split(block, level, children);
    }
    std::sort(children.begin(), children.end(),
              [](const Block& a, const Block& b) { return is_more_promising(a, b); });
    descend(children, level - kLevelsAtOnce);
  }
}

/// Heading by heading.
void LatticeSearch::split_top(const Block& block, std::vector<Block>& children) {
  Block of_heading = block;
  for (; of_heading.heading <= last_of_group(block.heading); ++of_heading.heading)
    split(of_heading, top_level_, children);
}

void LatticeSearch::split(const Block& block, int level, std::vector<Block>& children) {
  if (excluded_ && is_excluded(block, level)) return;
  const int below = level - kLevelsAtOnce;
  const int side = 1 << below;
  const auto inside = [&](int from) {
    return std::min(kTileSide, (lattice_.half_cells - from) / side + 1);
  };
  add_children(levels_[static_cast<std::size_t>(below / kLevelsAtOnce)], block,
               inside(block.column), inside(block.row), side, children);
}

/// Beats the best, or equals it and comes first. (A block's first shift is its earliest.)
bool LatticeSearch::may_win(const Block& block) const {
  return block.bound > best_.bound ||
         (found_ && block.bound == best_.bound && is_earlier(block, best_));
}

bool LatticeSearch::is_excluded(int heading, int column, int row, double margin_m) const {
  if (!excluded_) return false;
  const Pose2 pose = lattice_.pose_at(static_cast<std::size_t>(heading), column, row);
  return hypotenuse(pose.x - excluded_->pose.x, pose.y - excluded_->pose.y) + margin_m <
             excluded_->radius_m &&
         std::abs(wrap_angle(pose.yaw - excluded_->pose.yaw)) < excluded_->half_yaw_rad;
}

/// Are all shifts of the block left out? A disc that holds the corners holds what lies between
/// them.
bool LatticeSearch::is_excluded(const Block& block, int level) const {
  constexpr double kRounding = 1e-9;
  const int last = (1 << level) - 1;
  for (const int row : {block.row, block.row + last}) {
    for (const int column : {block.column, block.column + last}) {
      if (!is_excluded(block.heading, column, row, kRounding)) return false;
    }
  }
  return true;
}

}  // namespace loopstone
