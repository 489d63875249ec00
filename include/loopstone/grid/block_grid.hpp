#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// A grid without edges: memory only for the 16 x 16 blocks that were written to, and 4 bytes for
/// each block of the box around them. Cell (0, 0) has its lower left corner at the origin of the
/// plane; cells may be negative.
template <typename T>
class BlockGrid {
 public:
  static constexpr int kBlockBits = 4;
  static constexpr int kBlockSide = 1 << kBlockBits;

  explicit BlockGrid(double resolution_m)
      : resolution_m_(resolution_m), inverse_(1.0 / resolution_m) {}

  [[nodiscard]] double resolution_m() const { return resolution_m_; }

  [[nodiscard]] Cell cell_of(double x, double y) const {
    return {floor_to_int(x * inverse_), floor_to_int(y * inverse_)};
  }
  [[nodiscard]] Eigen::Vector2d centre_of(Cell cell) const {
    return {(cell.column + 0.5) * resolution_m_, (cell.row + 0.5) * resolution_m_};
  }

  /// The cell, or nullptr where nothing was ever written. Cost: O(1).
  [[nodiscard]] const T* find(Cell cell) const {
    const int block_column = (cell.column >> kBlockBits) - first_block_.column;
    const int block_row = (cell.row >> kBlockBits) - first_block_.row;
    if (static_cast<unsigned>(block_column) >= static_cast<unsigned>(block_columns_) ||
        static_cast<unsigned>(block_row) >= static_cast<unsigned>(block_rows_)) {
      return nullptr;
    }
    const std::int32_t block =
        directory_[static_cast<std::size_t>(block_row) * static_cast<std::size_t>(block_columns_) +
                   static_cast<std::size_t>(block_column)];
    if (block < 0) return nullptr;
    return &cells_[offset_in(block, cell)];
  }

  /// The cell, made if need be. Throws UsageError when the box would have more than 2^26 blocks.
  [[nodiscard]] T& at(Cell cell) {
    const Cell block_cell{cell.column >> kBlockBits, cell.row >> kBlockBits};
    if (!covers(block_cell)) grow_to(block_cell);
    std::int32_t& block =
        directory_[static_cast<std::size_t>(block_cell.row - first_block_.row) *
                       static_cast<std::size_t>(block_columns_) +
                   static_cast<std::size_t>(block_cell.column - first_block_.column)];
    if (block < 0) {
      block = static_cast<std::int32_t>(cells_.size() / kBlockCells);
      cells_.resize(cells_.size() + kBlockCells);
    }
    return cells_[offset_in(block, cell)];
  }

  /// Whether a cell and the eight around it lie in one block: then they are kBlockSide apart from
  /// row to row.
  [[nodiscard]] static bool is_inside_block(Cell cell) {
    const auto inside = [](int i) {
      return static_cast<unsigned>((i & (kBlockSide - 1)) - 1) < kBlockSide - 2;
    };
    return inside(cell.column) && inside(cell.row);
  }

  /// Calls visit(Cell, const T&) for every cell of every block, in an order that depends only on
  /// what was written where.
  template <typename Visitor>
  void for_each(Visitor&& visit) const {
    for (int row = 0; row < block_rows_; ++row) {
      for (int column = 0; column < block_columns_; ++column) {
        const std::int32_t block =
            directory_[static_cast<std::size_t>(row) * static_cast<std::size_t>(block_columns_) +
                       static_cast<std::size_t>(column)];
        if (block < 0) continue;
        for (int inner = 0; inner < kBlockCells; ++inner) {
          const Cell cell{
              ((column + first_block_.column) << kBlockBits) + (inner & (kBlockSide - 1)),
              ((row + first_block_.row) << kBlockBits) + (inner >> kBlockBits)};
          visit(cell, cells_[static_cast<std::size_t>(block) * kBlockCells +
                             static_cast<std::size_t>(inner)]);
        }
      }
    }
  }

  [[nodiscard]] bool empty() const { return cells_.empty(); }

  /// With its resolution. Of each block, a bit for every cell that is not as new (row by row,
  /// lowest bit first), and those cells.
  template <typename Archive>
  void archive(Archive& a) {
    a(resolution_m_, first_block_, block_columns_, block_rows_, directory_);
    a.check(resolution_m_ > 0.0 && std::isfinite(resolution_m_), "a grid of cells without a size");
    if constexpr (Archive::kReads) inverse_ = 1.0 / resolution_m_;
    std::uint64_t blocks = cells_.size() / kBlockCells;
    a(blocks);
    a.check(directory_fits(blocks), "a grid whose directory contradicts its blocks");
    if constexpr (Archive::kReads) cells_.clear();
    for (std::size_t block = 0; block < blocks; ++block) {
      if constexpr (Archive::kReads) cells_.resize(cells_.size() + kBlockCells);
      T* const cells = &cells_[block * kBlockCells];
      std::array<std::uint64_t, kBlockCells / 64> used{};
      if constexpr (!Archive::kReads) used = used_of(cells);
      a(used);
      for (std::size_t i = 0; i < kBlockCells; ++i) {
        if ((used[i / 64] >> (i % 64)) & 1U) a(cells[i]);
      }
    }
  }

 private:
  static constexpr int kBlockCells = kBlockSide * kBlockSide;
  static constexpr std::int64_t kMostBlocks = std::int64_t{1} << 26;

  [[nodiscard]] static std::size_t offset_in(std::int32_t block, Cell cell) {
    return static_cast<std::size_t>(block) * kBlockCells +
           static_cast<std::size_t>((cell.row & (kBlockSide - 1)) << kBlockBits) +
           static_cast<std::size_t>(cell.column & (kBlockSide - 1));
  }
  [[nodiscard]] static std::array<std::uint64_t, kBlockCells / 64> used_of(const T* cells) {
    // By bytes: -0.0 is not as new, and must come back as it is.
    using Bytes = std::array<unsigned char, sizeof(T)>;
    const auto fresh = std::bit_cast<Bytes>(T{});
    std::array<std::uint64_t, kBlockCells / 64> used{};
    for (std::size_t i = 0; i < kBlockCells; ++i) {
      if (std::bit_cast<Bytes>(cells[i]) != fresh) used[i / 64] |= std::uint64_t{1} << (i % 64);
    }
    return used;
  }
  /// Whether every block can be reached and every look-up ends inside; for what comes from a file.
  [[nodiscard]] bool directory_fits(std::uint64_t blocks) const {
    constexpr int kFarthest = 1 << 24;
    const auto near = [](int value) { return value >= -kFarthest && value <= kFarthest; };
    const auto block = [&](std::int32_t b) {
      return b >= -1 && b < static_cast<std::int64_t>(blocks);
    };
    return near(first_block_.column) && near(first_block_.row) && block_columns_ >= 0 &&
           block_rows_ >= 0 && near(block_columns_) && near(block_rows_) &&
           static_cast<std::uint64_t>(block_columns_) * static_cast<std::uint64_t>(block_rows_) ==
               directory_.size() &&
           blocks <= directory_.size() && std::ranges::all_of(directory_, block);
  }
  [[nodiscard]] bool covers(Cell block) const {
    return block.column >= first_block_.column && block.row >= first_block_.row &&
           block.column < first_block_.column + block_columns_ &&
           block.row < first_block_.row + block_rows_;
  }
  void grow_to(Cell block) {
    constexpr int kMargin = 4;
    const bool fresh = directory_.empty();
    const int low_column =
        fresh ? block.column - kMargin : std::min(first_block_.column, block.column - kMargin);
    const int low_row =
        fresh ? block.row - kMargin : std::min(first_block_.row, block.row - kMargin);
    const int high_column =
        fresh ? block.column + kMargin
              : std::max(first_block_.column + block_columns_ - 1, block.column + kMargin);
    const int high_row = fresh ? block.row + kMargin
                               : std::max(first_block_.row + block_rows_ - 1, block.row + kMargin);
    const int columns = high_column - low_column + 1;
    const int rows = high_row - low_row + 1;
    if (std::int64_t{columns} * rows > kMostBlocks) {
      throw UsageError("points lie too far apart for one grid: some coordinates are wrong");
    }
    std::vector<std::int32_t> directory(
        static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), -1);
    for (int row = 0; row < block_rows_; ++row) {
      std::copy_n(directory_.begin() + static_cast<std::ptrdiff_t>(row) * block_columns_,
                  block_columns_,
                  directory.begin() +
                      static_cast<std::ptrdiff_t>(row + first_block_.row - low_row) * columns +
                      (first_block_.column - low_column));
    }
    directory_ = std::move(directory);
    first_block_ = {low_column, low_row};
    block_columns_ = columns;
    block_rows_ = rows;
  }

  double resolution_m_;
  double inverse_;
  Cell first_block_{};
  int block_columns_ = 0;
  int block_rows_ = 0;
  std::vector<std::int32_t> directory_{};
  std::vector<T> cells_{};
};

}  // namespace loopstone
