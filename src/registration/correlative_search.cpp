#include "loopstone/registration/correlative_search.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "loopstone/geometry/angle.hpp"
#include "registration/search_block.hpp"
#include "registration/search_lattice.hpp"
#include "registration/shift_sums.hpp"

namespace loopstone {

namespace {

constexpr int kLanes = MaxPyramid::kLanes;
/// So many points are summed before a look at whether the rest can still matter.
constexpr std::size_t kChunk = 128;
static_assert(kChunk <= ScanOnLevel::kMaxCells);

/// From a level to the one that its blocks are split into: a block of four by four children is
/// summed in four reads a point.
int level_below(int level) { return level % 2 == 1 ? level - 1 : level - 2; }

/// The coarsest level worth starting with: the window in no more blocks than are read at once.
int top_level_for(const MaxPyramid& target, int half_cells) {
  int level = 0;
  while (level + 2 < target.level_count() && ((2 * half_cells) >> level) >= kLanes) level += 2;
  return level;
}

class Search {
 public:
  Search(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
         const SearchWindow& window, const std::optional<ExcludedPoses>& excluded,
         std::int32_t floor)
      : lattice_(make_search_lattice(source, target.frame(), window)),
        cells_(cells_at_headings(source, target.frame(), lattice_)),
        excluded_(excluded),
        points_(source.size()),
        top_level_(top_level_for(target, lattice_.half_cells)) {
    best_.bound = floor;
    for (int level = 0; level <= top_level_; ++level) {
      row_tables_.emplace_back(target.level(level), 2 * lattice_.half_cells + (1 << level));
    }
    for (int level = 0; level <= top_level_; ++level) {
      scans_.emplace_back(target.level(level), row_tables_[static_cast<std::size_t>(level)]);
    }
  }

  [[nodiscard]] SearchResult run() {
    std::vector<SearchBlock> blocks = all_blocks();
    descend(blocks, top_level_);
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

 private:
  /// The whole window in blocks of the top level, those that may win.
  [[nodiscard]] std::vector<SearchBlock> all_blocks() {
    std::vector<SearchBlock> blocks;
    const int side = 1 << top_level_;
    const int count = 2 * lattice_.half_cells / side + 1;
    ScanOnLevel& scan = scans_.back();
    for (std::size_t heading = 0; heading < cells_.size(); ++heading) {
      scan.lay(cells_[heading], -lattice_.half_cells, -lattice_.half_cells);
      for (int first = 0; first < count; first += kLanes) {
        scan.choose_lanes(first);
        for (int line = 0; line < count; ++line) {
          add_children(scan,
                       {0, static_cast<std::int32_t>(heading), first * side - lattice_.half_cells,
                        -lattice_.half_cells},
                       line, std::min(kLanes, count - first), side, blocks);
        }
      }
    }
    return blocks;
  }

  /// One row of blocks, `line` blocks above the corner that the scan was laid at: those that may
  /// win.
  void add_children(const ScanOnLevel& scan, const SearchBlock& corner, int line, int count,
                    int side, std::vector<SearchBlock>& blocks) {
    LaneSums sums{};
    evaluations_ += count;
    for (std::size_t begin = 0; begin < points_; begin += kChunk) {
      const std::size_t end = std::min(begin + kChunk, points_);
      scan.add(line * side, begin, end, sums);
      if (end == points_) break;
      const auto rest = static_cast<std::int32_t>(points_ - end) * kSurface;
      if (*std::max_element(sums.begin(), sums.begin() + count) + rest < best_.bound) return;
    }
    for (int lane = 0; lane < count; ++lane) {
      const SearchBlock block{sums[static_cast<std::size_t>(lane)], corner.heading,
                              corner.column + lane * side, corner.row + line * side};
      if (may_win(block)) blocks.push_back(block);
    }
  }

  /// Looks into every block that may beat the best leaf, the most promising first.
  void descend(std::vector<SearchBlock>& blocks, int level) {
    std::sort(blocks.begin(), blocks.end(), is_more_promising);
    std::vector<SearchBlock> children;
    for (const SearchBlock& block : blocks) {
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
      if (excluded_ && is_excluded(block, level)) continue;
      children.clear();
      split(block, level, children);
      descend(children, level_below(level));
    }
  }

  void split(const SearchBlock& block, int level, std::vector<SearchBlock>& children) {
    const int below = level_below(level);
    const int side = 1 << below;
    const int ratio = 1 << (level - below);
    ScanOnLevel& scan = scans_[static_cast<std::size_t>(below)];
    scan.lay(cells_[static_cast<std::size_t>(block.heading)], block.column, block.row);
    scan.choose_lanes(0);
    const auto inside = [&](int from) {
      return std::min(ratio, (lattice_.half_cells - from) / side + 1);
    };
    for (int line = 0; line < inside(block.row); ++line)
      add_children(scan, block, line, inside(block.column), side, children);
  }

  /// Beats the best, or equals it and comes first. (A block's first shift is its earliest.)
  [[nodiscard]] bool may_win(const SearchBlock& block) const {
    return block.bound > best_.bound ||
           (found_ && block.bound == best_.bound && is_earlier(block, best_));
  }

  [[nodiscard]] bool is_excluded(int heading, int column, int row, double margin_m = 0.0) const {
    if (!excluded_) return false;
    const Pose2 pose = lattice_.pose_at(static_cast<std::size_t>(heading), column, row);
    return std::hypot(pose.x - excluded_->pose.x, pose.y - excluded_->pose.y) + margin_m <
               excluded_->radius_m &&
           std::abs(wrap_angle(pose.yaw - excluded_->pose.yaw)) < excluded_->half_yaw_rad;
  }

  /// Are all shifts of the block left out? A disc that holds the corners holds what lies between
  /// them.
  [[nodiscard]] bool is_excluded(const SearchBlock& block, int level) const {
    constexpr double kRounding = 1e-9;
    const int last = (1 << level) - 1;
    for (const int row : {block.row, block.row + last}) {
      for (const int column : {block.column, block.column + last}) {
        if (!is_excluded(block.heading, column, row, kRounding)) return false;
      }
    }
    return true;
  }

  SearchLattice lattice_;
  std::vector<CellList> cells_;
  const std::optional<ExcludedPoses>& excluded_;
  std::size_t points_;
  int top_level_;
  std::vector<RowTable> row_tables_{};
  std::vector<ScanOnLevel> scans_{};
  SearchBlock best_{};
  bool found_ = false;
  std::int64_t evaluations_ = 0;
};

}  // namespace

SearchResult search_branch_and_bound(std::span<const Eigen::Vector2d> source,
                                     const MaxPyramid& target, const SearchWindow& window,
                                     double min_score,
                                     const std::optional<ExcludedPoses>& excluded) {
  if (source.empty()) return {};
  // The least sum that still counts, less one: what a sum has to beat.
  const std::int32_t floor = least_sum(min_score, source.size()) - 1;
  return Search(source, target, window, excluded, floor).run();
}

}  // namespace loopstone
