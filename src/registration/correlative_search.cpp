#include "loopstone/registration/correlative_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// The source's points at one heading, as cells of the target with the centre of the window's translations.
using RotatedCells = std::vector<Cell>;

/// The window cut into headings and whole-cell shifts around its centre.
struct Lattice {
  Eigen::Vector2d pivot;            // the source's centre of mass, source frame
  Eigen::Vector2d pivot_in_target;  // where the window's centre puts it
  std::vector<double> headings;
  int half_cells = 0;               // shifts run over [-half_cells, half_cells] in column and row
  std::vector<RotatedCells> cells;  // one entry a heading
  double resolution_m = 0.0;

  [[nodiscard]] Pose2 pose_at(std::size_t heading, int column, int row) const {
    const Pose2 rotation{0.0, 0.0, headings[heading]};
    const Eigen::Vector2d moved_pivot =
        pivot_in_target + resolution_m * Eigen::Vector2d(column, row);
    const Eigen::Vector2d translation = moved_pivot - rotation * pivot;
    return {translation.x(), translation.y(), wrap_angle(headings[heading])};
  }
};

Lattice make_lattice(std::span<const Eigen::Vector2d> source, const GridFrame& frame,
                     const SearchWindow& window) {
  Lattice lattice;
  lattice.resolution_m = frame.resolution;
  lattice.pivot = Eigen::Vector2d::Zero();
  for (const auto& point : source) lattice.pivot += point;
  lattice.pivot /= static_cast<double>(source.size());
  lattice.pivot_in_target = window.centre * lattice.pivot;
  double reach = frame.resolution;
  for (const auto& point : source) reach = std::max(reach, (point - lattice.pivot).norm());
  const double step = frame.resolution / reach;
  const int half_headings = std::min(static_cast<int>(std::ceil(window.half_yaw_rad / step)),
                                     static_cast<int>(std::floor(kPi / step)));
  for (int i = -half_headings; i <= half_headings; ++i) {
    lattice.headings.push_back(window.centre.yaw + i * step);
  }
  lattice.half_cells = static_cast<int>(std::ceil(window.half_xy_m / frame.resolution));
  lattice.cells.reserve(lattice.headings.size());
  for (const double heading : lattice.headings) {
    const Eigen::Matrix2d rotation = Pose2{0.0, 0.0, heading}.rotation();
    RotatedCells cells;
    cells.reserve(source.size());
    for (const auto& point : source) {
      cells.push_back(frame.cell_of(lattice.pivot_in_target + rotation * (point - lattice.pivot)));
    }
    lattice.cells.push_back(std::move(cells));
  }
  return lattice;
}

/// Sum of the bounds of all points for the block of shifts that starts at (column, row).
/// Gives up, returning a value no greater than `floor`, once the rest can't lift the sum above it.
std::int32_t block_sum(const MaxPyramid& target, const RotatedCells& cells, int level, int column,
                       int row, std::int32_t floor) {
  constexpr std::size_t kChunk = 64;
  std::int32_t sum = 0;
  for (std::size_t start = 0; start < cells.size(); start += kChunk) {
    const std::size_t end = std::min(start + kChunk, cells.size());
    for (std::size_t i = start; i < end; ++i) {
      sum += target.bound(level, cells[i].column + column, cells[i].row + row);
    }
    const auto rest = static_cast<std::int32_t>(cells.size() - end) * kSurface;
    if (sum + rest <= floor) return sum + rest;
  }
  return sum;
}

bool is_excluded(const Pose2& pose, const std::optional<ExcludedPoses>& excluded) {
  return excluded &&
         std::hypot(pose.x - excluded->pose.x, pose.y - excluded->pose.y) < excluded->radius_m &&
         std::abs(wrap_angle(pose.yaw - excluded->pose.yaw)) < excluded->half_yaw_rad;
}

/// A block of 2^level x 2^level shifts at one heading.
struct Block {
  std::int32_t bound;
  std::size_t heading;
  int column;
  int row;
};

/// Highest bound first; ties by position, so that the order never depends on the sort.
bool better(const Block& a, const Block& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  if (a.heading != b.heading) return a.heading < b.heading;
  if (a.row != b.row) return a.row < b.row;
  return a.column < b.column;
}

/// Is (heading, row, column) of a before that of b? Decides between equal scores.
bool earlier(const Block& a, const Block& b) {
  if (a.heading != b.heading) return a.heading < b.heading;
  if (a.row != b.row) return a.row < b.row;
  return a.column < b.column;
}

/// The smallest sum that still counts, less one: what a sum has to beat.
std::int32_t floor_of(double min_score, std::size_t points) {
  const double sum = static_cast<double>(points) * (kUnknown + min_score * (kSurface - kUnknown));
  return static_cast<std::int32_t>(std::ceil(sum)) - 1;
}

double score_of(std::int32_t sum, std::size_t points) {
  return (static_cast<double>(sum) / static_cast<double>(points) - kUnknown) /
         (kSurface - kUnknown);
}

class Search {
 public:
  Search(const MaxPyramid& target, const Lattice& lattice,
         const std::optional<ExcludedPoses>& excluded, std::int32_t floor)
      : target_(target), lattice_(lattice), excluded_(excluded) {
    best_.bound = floor;
  }

  /// Looks into every block whose bound may beat the best leaf, the most promising first.
  void descend(std::vector<Block>& blocks, int level) {
    std::sort(blocks.begin(), blocks.end(), better);
    for (const Block& block : blocks) {
      if (!may_win(block)) {
        if (block.bound < best_.bound) break;
        continue;
      }
      if (level == 0) {
        if (!is_excluded(lattice_.pose_at(block.heading, block.column, block.row), excluded_)) {
          best_ = block;
          found_ = true;
        }
        continue;
      }
      const int half = 1 << (level - 1);
      std::vector<Block> children;
      for (const int row : {block.row, block.row + half}) {
        for (const int column : {block.column, block.column + half}) {
          if (row > lattice_.half_cells || column > lattice_.half_cells) continue;
          children.push_back(evaluated({0, block.heading, column, row}, level - 1));
        }
      }
      descend(children, level - 1);
    }
  }

  [[nodiscard]] Block evaluated(Block block, int level) {
    ++evaluations_;
    // One less than the best, so that ties stay comparable.
    block.bound = block_sum(target_, lattice_.cells[block.heading], level, block.column, block.row,
                            best_.bound - 1);
    return block;
  }

  [[nodiscard]] SearchResult result() const {
    SearchResult result;
    result.found = found_;
    result.evaluations = evaluations_;
    if (found_) {
      result.target_T_source = lattice_.pose_at(best_.heading, best_.column, best_.row);
      result.score = score_of(best_.bound, lattice_.cells[best_.heading].size());
    }
    return result;
  }

 private:
  /// Beats the best, or equals it and comes first. (A block's first shift is its earliest.)
  [[nodiscard]] bool may_win(const Block& block) const {
    return block.bound > best_.bound ||
           (found_ && block.bound == best_.bound && earlier(block, best_));
  }

  const MaxPyramid& target_;
  const Lattice& lattice_;
  const std::optional<ExcludedPoses>& excluded_;
  Block best_{};
  bool found_ = false;
  std::int64_t evaluations_ = 0;
};

}  // namespace

SearchResult search_branch_and_bound(std::span<const Eigen::Vector2d> source,
                                     const MaxPyramid& target, const SearchWindow& window,
                                     double min_score,
                                     const std::optional<ExcludedPoses>& excluded) {
  if (source.empty()) return {};
  const Lattice lattice = make_lattice(source, target.frame(), window);
  // Blocks no larger than the window: a coarser start only loosens the bounds.
  int top_level = 0;
  while (top_level + 1 < target.level_count() && (1 << (top_level + 1)) <= lattice.half_cells)
    ++top_level;
  const int side = 1 << top_level;

  Search search(target, lattice, excluded, floor_of(min_score, source.size()));
  std::vector<Block> blocks;
  for (std::size_t heading = 0; heading < lattice.headings.size(); ++heading) {
    for (int row = -lattice.half_cells; row <= lattice.half_cells; row += side) {
      for (int column = -lattice.half_cells; column <= lattice.half_cells; column += side) {
        blocks.push_back(search.evaluated({0, heading, column, row}, top_level));
      }
    }
  }
  search.descend(blocks, top_level);
  return search.result();
}

}  // namespace loopstone
