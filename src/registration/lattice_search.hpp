#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "registration/search_block.hpp"
#include "registration/search_lattice.hpp"
#include "registration/tile_reader.hpp"

namespace loopstone {

/// search_branch_and_bound for more than one question to the same window: what was laid out and
/// bounded for the first serves the next.
class LatticeSearch {
 public:
  /// \param source  not empty
  /// \param target  must outlive the search
  LatticeSearch(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                const SearchWindow& window);

  /// The best pose of the window, but for excluded ones. Cheaper than the first where `min_score`
  /// is no less than that of an earlier call.
  [[nodiscard]] SearchResult best(double min_score,
                                  const std::optional<ExcludedPoses>& excluded = {});

 private:
  /// The points are summed part by part, with a look after each whether the rest can still matter.
  static constexpr std::size_t kParts = 5;

  /// With the share of its bound that the points after each part have.
  struct Block : SearchBlock {
    std::array<std::int32_t, kParts - 1> rest{};
  };

  void bound_window();
  void bound_tile(const Block& parent, int columns, int rows);
  void add_children(TileReader& level, const Block& parent, int columns, int rows, int side,
                    std::vector<Block>& children);
  void add_winners(const std::array<TileSums, kParts>& sums, const Block& parent, int columns,
                   int rows, int side, std::vector<Block>& children) const;
  [[nodiscard]] const CellList& cells_of(int heading);
  [[nodiscard]] int last_of_group(int heading) const;
  void descend(std::vector<Block>& blocks, int level);
  void split_top(const Block& block, std::vector<Block>& children);
  void split(const Block& block, int level, std::vector<Block>& children);
  [[nodiscard]] bool may_win(const Block& block) const;
  [[nodiscard]] bool is_excluded(int heading, int column, int row, double margin_m = 0.0) const;
  [[nodiscard]] bool is_excluded(const Block& block, int level) const;
  [[nodiscard]] std::size_t part_end(std::size_t part) const {
    return points_ * (part + 1) / kParts;
  }

  SearchLattice lattice_;
  GridFrame frame_;
  std::size_t points_;
  int top_level_;
  /// Blocks of the top level stand for so many headings before and behind the one that they are
  /// summed at, and are wider by so many cells.
  int group_half_;
  int margin_;
  CellArea area_;
  std::vector<Eigen::Vector2d> arms_;
  std::vector<CellList> cells_;       ///< by heading, of the area; once they were asked for
  std::vector<TileReader> levels_{};  ///< every other one, the finest first
  std::vector<Block> top_blocks_{};   ///< that beat `top_floor_`; with their first heading
  std::optional<std::int32_t> top_floor_{};
  std::optional<ExcludedPoses> excluded_{};
  Block best_{};
  bool found_ = false;
  std::int64_t evaluations_ = 0;
};

}  // namespace loopstone
