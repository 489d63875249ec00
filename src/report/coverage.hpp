#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "report/outline.hpp"

namespace loopstone {

/// A rectangle that need not end at whole pixels.
struct PixelBox {
  double left = 0.0;
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;
};

/// Pixels beside each other in a row that a shape covers by the same share.
struct CoveredRun {
  int row;
  int column;
  int length;
  std::uint32_t share;  ///< of each pixel, in 1/65536
};

/// How much of each pixel a shape covers, exactly: the area on it of what its curves go round.
/// Points are rounded to 1/256 px, and everything after that is in whole numbers, so that machines
/// and compilers agree.
class Coverage {
 public:
  /// Nothing outside of the box is covered. It must lie within 0 and 2^22 px.
  explicit Coverage(const PixelBox& box) : box_(box) {}

  /// A curve with a coordinate that is no number, or beyond 10^12, is left out whole.
  void add(std::span<const Point> contour);
  void add(std::span<const Contour> contours);
  /// By row, then by column.
  [[nodiscard]] std::vector<CoveredRun> runs();

 private:
  /// What the edges within a pixel do: how far down they go, and twice the area between them and
  /// the pixel's left side; in 1/256 px.
  struct Cell {
    std::int32_t row;
    std::int32_t column;
    std::int32_t down;
    std::int32_t twice_area;
  };
  void add_edge(Point from, Point to);
  void add_piece(Point from, Point to, bool goes_down);
  void add_in_row(int row, std::int64_t x_from, std::int64_t x_to, std::int64_t y_from,
                  std::int64_t y_to, std::int32_t sign);
  void add_cell(const Cell& cell);

  PixelBox box_;
  std::vector<Cell> cells_{};
};

}  // namespace loopstone
