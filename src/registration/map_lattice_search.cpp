#include "registration/map_lattice_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "registration/search_block.hpp"
#include "registration/shift_sums.hpp"

namespace loopstone {

namespace {

constexpr int kLanes = MaxPyramid::kLanes;
constexpr std::size_t kChunk = 32;
/// Blocks of 8 x 8 cells: larger ones bound too loosely, smaller ones are too many.
constexpr int kTopLevel = 3;
constexpr int kSide = 1 << kTopLevel;
/// Headings to either side of a middle one that are bounded with it. From one to the next no point
/// moves by more than a cell, so that all of them look into a window larger by so many cells on
/// each side: one of the next level.
constexpr int kGroupHalf = 4;
constexpr int kGroupLevel = kTopLevel + 1;
static_assert(1 << kGroupLevel == kSide + 2 * kGroupHalf);
/// Points that are enough to see which blocks are promising.
constexpr std::size_t kFewPoints = 64;
/// Blocks of so many cells a side, of which a block of the top level has two by two.
constexpr int kHalfLevel = kTopLevel - 1;
constexpr int kHalfSide = 1 << kHalfLevel;

/// Offsets of the points' cells from the cell at whose centre the source's origin stands.
CellList cells_at(std::span<const Eigen::Vector2d> points, double heading, double resolution_m) {
  const double cosine = std::cos(heading) / resolution_m;
  const double sine = std::sin(heading) / resolution_m;
  CellList cells;
  cells.columns.reserve(points.size());
  cells.rows.reserve(points.size());
  for (const auto& point : points) {
    const double x = cosine * point.x() - sine * point.y() + 0.5;
    const double y = sine * point.x() + cosine * point.y() + 0.5;
    cells.columns.push_back(floor_to_int(x));
    cells.rows.push_back(floor_to_int(y));
  }
  return cells;
}

class MapLatticeSearch {
 public:
  MapLatticeSearch(std::span<const Eigen::Vector2d> points, const MapSearch& map,
                   const MapLattice& lattice, double min_score, double margin)
      : points_(points),
        map_(map),
        frame_(map.pyramid().frame()),
        lattice_(lattice),
        min_score_(min_score),
        count_(points.size()),
        top_rows_(map.pyramid().level(kTopLevel), frame_.rows + kSide),
        leaf_rows_(map.pyramid().level(0), kSide),
        group_rows_(map.pyramid().level(kGroupLevel), frame_.rows + kSide),
        half_rows_(map.pyramid().level(kHalfLevel), kSide),
        top_scan_(map.pyramid().level(kTopLevel), top_rows_),
        leaf_scan_(map.pyramid().level(0), leaf_rows_),
        half_scan_(map.pyramid().level(kHalfLevel), half_rows_),
        group_scans_{ScanOnLevel(map.pyramid().level(kGroupLevel), group_rows_),
                     ScanOnLevel(map.pyramid().level(kGroupLevel), group_rows_)} {
    const auto per_point = static_cast<double>(kSurface - kUnknown);
    margin_ =
        static_cast<std::int32_t>(std::floor(static_cast<double>(count_) * margin * per_point));
    floor_ = least_sum(min_score, count_);
  }

  [[nodiscard]] LatticePoses run() {
    find_strips();
    pair_strips();
    for (const double heading : lattice_.headings)
      cells_.push_back(cells_at(points_, heading, frame_.resolution));
    raise_floor();
    std::vector<SearchBlock> blocks;
    for (std::size_t first = 0; first < cells_.size(); first += 2 * kGroupHalf + 1)
      bound_group(first, blocks);
    std::sort(blocks.begin(), blocks.end(), is_more_promising);
    std::vector<SearchBlock> leaves;
    for (const SearchBlock& block : blocks) {
      if (block.bound < floor_) break;
      const SearchBlock leaf = best_leaf(block);
      if (leaf.bound < floor_) continue;
      leaves.push_back(leaf);
      floor_ = std::max(floor_, leaf.bound - margin_);
    }
    std::sort(leaves.begin(), leaves.end(), is_more_promising);
    LatticePoses result;
    result.evaluations = evaluations_;
    for (const SearchBlock& leaf : leaves) {
      if (leaf.bound < floor_) break;
      const Eigen::Vector2d at = frame_.centre_of({leaf.column, leaf.row});
      result.poses.push_back(
          {{at.x(), at.y(), wrap_angle(lattice_.headings[static_cast<std::size_t>(leaf.heading)])},
           score_of(leaf.bound, count_)});
    }
    return result;
  }

 private:
  /// kLanes blocks side by side, of which at least one has a place to stand.
  struct Strip {
    int first_block;  // from the lattice's first column
    int line;         // from the lattice's first row
    std::array<bool, kLanes> open;
    bool active = true;  // one of its blocks may hold a pose of the group of headings in work
  };

  /// Two strips side by side, by their places; -1 where there is none.
  struct StripPair {
    int first_block;
    int line;
    std::array<std::int32_t, 2> strips;
  };

  void pair_strips() {
    const int lines = (lattice_.last.row - lattice_.first.row) / kSide + 1;
    std::vector<std::int32_t> at(static_cast<std::size_t>(lines), -1);  // of the pair on each line
    int first_block = -1;
    for (std::size_t i = 0; i < strips_.size(); ++i) {
      const Strip& strip = strips_[i];
      const int first = strip.first_block / (2 * kLanes) * (2 * kLanes);
      if (std::exchange(first_block, first) != first) std::ranges::fill(at, -1);
      auto& pair = at[static_cast<std::size_t>(strip.line)];
      if (pair < 0) {
        pair = static_cast<std::int32_t>(pairs_.size());
        pairs_.push_back({first, strip.line, {-1, -1}});
      }
      pairs_[static_cast<std::size_t>(pair)].strips[strip.first_block == first ? 0 : 1] =
          static_cast<std::int32_t>(i);
    }
  }

  void find_strips() {
    const int blocks = (lattice_.last.column - lattice_.first.column) / kSide + 1;
    const int lines = (lattice_.last.row - lattice_.first.row) / kSide + 1;
    for (int first = 0; first < blocks; first += kLanes) {
      for (int line = 0; line < lines; ++line) {
        Strip strip{first, line, {}};
        bool any = false;
        for (int lane = 0; lane < std::min(kLanes, blocks - first); ++lane) {
          const bool open = can_stand_in(
              {lattice_.first.column + (first + lane) * kSide, lattice_.first.row + line * kSide});
          strip.open[static_cast<std::size_t>(lane)] = open;
          any = any || open;
        }
        if (any) strips_.push_back(strip);
      }
    }
  }

  [[nodiscard]] bool can_stand_in(Cell corner) const {
    for (int row = corner.row; row <= std::min(corner.row + kSide - 1, lattice_.last.row); ++row) {
      for (int column = corner.column;
           column <= std::min(corner.column + kSide - 1, lattice_.last.column); ++column) {
        if (map_.standable()[{column, row}] != 0) return true;
      }
    }
    return false;
  }

  /// Sums the points for one row of blocks or shifts, or says early that none of them reaches what
  /// is the least.
  bool sum(const ScanOnLevel& scan, int row_shift, LaneSums& sums, std::int32_t least) const {
    for (std::size_t begin = 0; begin < count_; begin += kChunk) {
      const std::size_t end = std::min(begin + kChunk, count_);
      scan.add(row_shift, begin, end, sums);
      std::int32_t most = sums[0];
      for (std::size_t lane = 1; lane < sums.size(); ++lane) most = std::max(most, sums[lane]);
      if (most + static_cast<std::int32_t>(count_ - end) * kSurface < least) return false;
    }
    return true;
  }

  /// A good pose found early spares most of the work: blocks that can't come near it are given up
  /// after a few points. So looks at some headings only, by some points, and into the most
  /// promising blocks at the headings between them too.
  void raise_floor() {
    constexpr int kStride = 8;
    constexpr std::size_t kBlocks = 256;
    const int headings = static_cast<int>(cells_.size());
    if (headings < 2 * kStride) return;
    std::vector<SearchBlock> blocks;
    const std::size_t all = std::exchange(count_, std::min(count_, kFewPoints));
    std::int32_t least = least_sum(min_score_, count_);
    for (int h = kStride / 2; h < headings; h += kStride) {
      bound_heading(static_cast<std::size_t>(h), least, blocks);
      if (blocks.size() <= kBlocks) continue;
      const auto end = blocks.begin() + static_cast<std::ptrdiff_t>(kBlocks);
      std::nth_element(blocks.begin(), end - 1, blocks.end(), is_more_promising);
      blocks.erase(end, blocks.end());
      least = blocks.back().bound;
    }
    count_ = all;
    std::sort(blocks.begin(), blocks.end(), is_more_promising);
    for (SearchBlock block : blocks) {
      const int middle = block.heading;
      for (int h = std::max(0, middle - kStride / 2);
           h <= std::min(headings - 1, middle + kStride / 2); ++h) {
        block.heading = h;
        floor_ = std::max(floor_, best_leaf(block).bound - margin_);
      }
    }
  }

  /// Of up to 2 * kGroupHalf + 1 headings.
  void bound_group(std::size_t first, std::vector<SearchBlock>& blocks) {
    const std::size_t last = std::min(first + 2 * kGroupHalf, cells_.size() - 1);
    activate_strips(first + std::min<std::size_t>(kGroupHalf, last - first));
    for (std::size_t h = first; h <= last; ++h) bound_heading(h, floor_, blocks);
    for (Strip& strip : strips_) strip.active = true;
  }

  /// Leaves those strips active of which a block may reach the floor at a heading of the group.
  /// Windows of the group's level stand two blocks apart, so that kLanes of them reach over two
  /// strips side by side; those of the blocks between them are summed by a second scan.
  void activate_strips(std::size_t middle) {
    for (int odd = 0; odd < 2; ++odd) {
      group_scans_[static_cast<std::size_t>(odd)].lay(
          cells_[middle], lattice_.first.column - kGroupHalf + odd * kSide,
          lattice_.first.row - kGroupHalf);
    }
    for (Strip& strip : strips_) strip.active = false;
    int chosen = -1;
    for (const StripPair& pair : pairs_) {
      if (pair.first_block != chosen) {
        chosen = pair.first_block;
        for (ScanOnLevel& scan : group_scans_) scan.choose_lanes(chosen / 2);
      }
      for (std::size_t odd = 0; odd < 2; ++odd) {
        LaneSums sums{};
        evaluations_ += kLanes;
        if (!sum(group_scans_[odd], pair.line * kSide, sums, floor_)) continue;
        for (std::size_t lane = 0; lane < sums.size(); ++lane) {
          const std::size_t block = 2 * lane + odd;
          const std::int32_t at = pair.strips[block / kLanes];
          if (at < 0 || sums[lane] < floor_) continue;
          Strip& strip = strips_[static_cast<std::size_t>(at)];
          strip.active = strip.active || strip.open[block % kLanes];
        }
      }
    }
  }

  void bound_heading(std::size_t heading, std::int32_t least, std::vector<SearchBlock>& blocks) {
    top_scan_.lay(cells_[heading], lattice_.first.column, lattice_.first.row);
    int chosen = -1;
    for (const Strip& strip : strips_) {
      if (!strip.active) continue;
      if (strip.first_block != chosen) {
        chosen = strip.first_block;
        top_scan_.choose_lanes(chosen);
      }
      LaneSums sums{};
      evaluations_ += kLanes;
      if (!sum(top_scan_, strip.line * kSide, sums, least)) continue;
      for (int lane = 0; lane < kLanes; ++lane) {
        const std::int32_t bound = sums[static_cast<std::size_t>(lane)];
        if (bound < least || !strip.open[static_cast<std::size_t>(lane)]) continue;
        blocks.push_back({bound, static_cast<std::int32_t>(heading),
                          lattice_.first.column + (strip.first_block + lane) * kSide,
                          lattice_.first.row + strip.line * kSide});
      }
    }
  }

  /// By windows of half the size.
  [[nodiscard]] bool may_hold_leaf(const SearchBlock& block) {
    half_scan_.lay(cells_[static_cast<std::size_t>(block.heading)], block.column, block.row);
    half_scan_.choose_lanes(0);
    for (int row_shift = 0; row_shift < kSide; row_shift += kHalfSide) {
      LaneSums sums;
      sums.fill(-static_cast<std::int32_t>(count_) * kSurface);  // beyond the block
      sums[0] = sums[1] = 0;
      evaluations_ += 2;
      if (sum(half_scan_, row_shift, sums, floor_) && std::max(sums[0], sums[1]) >= floor_)
        return true;
    }
    return false;
  }

  /// The best pose of a block; its bound is below the floor when none reaches it.
  [[nodiscard]] SearchBlock best_leaf(const SearchBlock& block) {
    SearchBlock best = block;
    best.bound = floor_ - 1;
    if (!may_hold_leaf(block)) return best;
    leaf_scan_.lay(cells_[static_cast<std::size_t>(block.heading)], block.column, block.row);
    leaf_scan_.choose_lanes(0);
    for (int line = 0; line < std::min(kSide, lattice_.last.row - block.row + 1); ++line) {
      LaneSums sums{};
      evaluations_ += kSide;
      if (!sum(leaf_scan_, line, sums, floor_)) continue;
      for (int lane = 0; lane < std::min(kSide, lattice_.last.column - block.column + 1); ++lane) {
        const std::int32_t score = sums[static_cast<std::size_t>(lane)];
        const Cell cell{block.column + lane, block.row + line};
        if (score <= best.bound || map_.standable()[cell] == 0) continue;
        best = {score, block.heading, cell.column, cell.row};
      }
    }
    return best;
  }

  std::span<const Eigen::Vector2d> points_;
  const MapSearch& map_;
  GridFrame frame_;
  const MapLattice& lattice_;
  double min_score_;
  std::size_t count_;
  RowTable top_rows_;
  RowTable leaf_rows_;
  RowTable group_rows_;
  RowTable half_rows_;
  ScanOnLevel top_scan_;
  ScanOnLevel leaf_scan_;
  ScanOnLevel half_scan_;
  std::array<ScanOnLevel, 2> group_scans_;
  std::vector<Strip> strips_{};
  std::vector<StripPair> pairs_{};
  std::vector<CellList> cells_{};
  std::int32_t floor_ = 0;   // sums below are of no interest
  std::int32_t margin_ = 0;  // nor are those so far below the best
  std::int64_t evaluations_ = 0;
};

}  // namespace

MapLattice make_map_lattice(std::span<const Eigen::Vector2d> points, const MapSearch& map,
                            const std::optional<SearchWindow>& window) {
  const GridFrame& frame = map.pyramid().frame();
  double reach = frame.resolution;
  for (const auto& point : points) reach = std::max(reach, point.norm());
  const double centre = window ? window->centre.yaw : 0.0;
  const double half = window ? std::min(window->half_yaw_rad, kPi) : kPi;
  MapLattice lattice;
  const int steps = static_cast<int>(std::ceil(2.0 * half * reach / frame.resolution));
  // The full circle ends where it began.
  const int count = half < kPi ? steps + 1 : steps;
  for (int i = 0; i < count; ++i)
    lattice.headings.push_back(centre - half + 2.0 * half * i / std::max(steps, 1));
  lattice.first = {0, 0};
  lattice.last = {frame.columns - 1, frame.rows - 1};
  if (window) {
    const Eigen::Vector2d side = Eigen::Vector2d::Constant(window->half_xy_m);
    const Cell low = frame.cell_of(window->centre.translation() - side);
    const Cell high = frame.cell_of(window->centre.translation() + side);
    lattice.first = {std::max(low.column, 0), std::max(low.row, 0)};
    lattice.last = {std::min(high.column, lattice.last.column),
                    std::min(high.row, lattice.last.row)};
  }
  return lattice;
}

LatticePoses search_map_lattice(std::span<const Eigen::Vector2d> points, const MapSearch& map,
                                const MapLattice& lattice, double min_score, double margin) {
  if (points.empty() || lattice.first.column > lattice.last.column ||
      lattice.first.row > lattice.last.row) {
    return {};
  }
  return MapLatticeSearch(points, map, lattice, min_score, margin).run();
}

}  // namespace loopstone
