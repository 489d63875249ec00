#include "report/coverage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>
#include <utility>

namespace loopstone {
namespace {

constexpr std::int64_t kUnit = 256;  // parts of a pixel
constexpr std::int64_t kWholePixel = 2 * kUnit * kUnit;
constexpr double kFarthest = 1e12;  // [px]; beyond, cutting at the box loses its precision

std::int64_t fixed(double px) { return std::llround(px * static_cast<double>(kUnit)); }

Point at_y(Point a, Point b, double y) {
  return {a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), y};
}
Point at_x(Point a, Point b, double x) {
  return {x, a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x))};
}

std::uint32_t share_of(std::int64_t twice_area) {
  // Curves that overlap cover a pixel once.
  return static_cast<std::uint32_t>(std::min(std::abs(twice_area), kWholePixel) * 65536 /
                                    kWholePixel);
}

}  // namespace

void Coverage::add(std::span<const Point> contour) {
  const auto is_usable = [](const Point& p) {
    return std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest;
  };
  if (contour.empty() || !std::ranges::all_of(contour, is_usable)) return;
  Point from = contour.back();
  for (const Point& to : contour) {
    add_edge(from, to);
    from = to;
  }
}

void Coverage::add(std::span<const Contour> contours) {
  for (const Contour& contour : contours) add(contour);
}

/// What is above and below the box is cut off. What is beside it is laid on its side, where it
/// says as before how often the pixels to the right are gone round.
void Coverage::add_edge(Point from, Point to) {
  const bool goes_down = from.y < to.y;
  Point a = goes_down ? from : to;
  Point b = goes_down ? to : from;
  if (!(a.y < b.y) || b.y <= box_.top || a.y >= box_.bottom) return;
  const Point high = a;
  const Point low = b;
  if (a.y < box_.top) a = at_y(high, low, box_.top);
  if (b.y > box_.bottom) b = at_y(high, low, box_.bottom);
  Point cuts[4] = {a, b, b, b};
  int count = 1;
  const double sides[] = {a.x < b.x ? box_.left : box_.right, a.x < b.x ? box_.right : box_.left};
  for (const double side : sides) {
    if (std::min(a.x, b.x) < side && side < std::max(a.x, b.x)) {
      cuts[count] = at_x(a, b, side);
      cuts[count].y = std::clamp(cuts[count].y, cuts[count - 1].y, b.y);
      ++count;
    }
  }
  cuts[count] = b;
  for (int i = 0; i < count; ++i) {
    Point from_cut = cuts[i];
    Point to_cut = cuts[i + 1];
    from_cut.x = std::clamp(from_cut.x, box_.left, box_.right);
    to_cut.x = std::clamp(to_cut.x, box_.left, box_.right);
    add_piece(from_cut, to_cut, goes_down);
  }
}

/// A piece within the box, downwards, row by row.
void Coverage::add_piece(Point from, Point to, bool goes_down) {
  const std::int64_t x0 = fixed(from.x);
  const std::int64_t y0 = fixed(from.y);
  const std::int64_t x1 = fixed(to.x);
  const std::int64_t y1 = fixed(to.y);
  std::int64_t x = x0;
  std::int64_t y = y0;
  while (y < y1) {
    const std::int64_t row = y / kUnit;
    const std::int64_t y_next = std::min(y1, (row + 1) * kUnit);
    const std::int64_t x_next = y_next == y1 ? x1 : x0 + (y_next - y0) * (x1 - x0) / (y1 - y0);
    add_in_row(static_cast<int>(row), x, x_next, y, y_next, goes_down ? 1 : -1);
    x = x_next;
    y = y_next;
  }
}

/// From left to right whichever way it leans: areas are the same.
void Coverage::add_in_row(int row, std::int64_t x_from, std::int64_t x_to, std::int64_t y_from,
                          std::int64_t y_to, std::int32_t sign) {
  const std::int64_t x0 = std::min(x_from, x_to);
  const std::int64_t x1 = std::max(x_from, x_to);
  const std::int64_t height = y_to - y_from;
  std::int64_t x = x0;
  std::int64_t done = 0;
  do {
    const std::int64_t column = x / kUnit;
    const std::int64_t x_next = std::min(x1, (column + 1) * kUnit);
    const std::int64_t done_next = x_next == x1 ? height : (x_next - x0) * height / (x1 - x0);
    const auto down = static_cast<std::int32_t>(done_next - done) * sign;
    const auto sides = static_cast<std::int32_t>(x + x_next - 2 * column * kUnit);
    add_cell({row, static_cast<std::int32_t>(column), down, down * sides});
    x = x_next;
    done = done_next;
  } while (x < x1);
}

void Coverage::add_cell(const Cell& cell) {
  if (!cells_.empty() && cells_.back().row == cell.row && cells_.back().column == cell.column) {
    cells_.back().down += cell.down;
    cells_.back().twice_area += cell.twice_area;
  } else {
    cells_.push_back(cell);
  }
}

std::vector<CoveredRun> Coverage::runs() {
  std::ranges::sort(cells_, [](const Cell& a, const Cell& b) {
    return std::tie(a.row, a.column) < std::tie(b.row, b.column);
  });
  const auto end_column = static_cast<std::int32_t>(std::ceil(box_.right));
  std::vector<CoveredRun> found;
  std::int64_t down = 0;
  for (std::size_t i = 0; i < cells_.size();) {
    const std::int32_t row = cells_[i].row;
    const std::int32_t column = cells_[i].column;
    std::int64_t beside = 0;
    for (; i < cells_.size() && cells_[i].row == row && cells_[i].column == column; ++i) {
      down += cells_[i].down;
      beside += cells_[i].twice_area;
    }
    if (column >= end_column) continue;
    if (const std::uint32_t share = share_of(2 * kUnit * down - beside); share > 0)
      found.push_back({row, column, 1, share});
    const bool goes_on = i < cells_.size() && cells_[i].row == row;
    const std::int32_t next = goes_on ? std::min(cells_[i].column, end_column) : column + 1;
    if (const std::uint32_t share = share_of(2 * kUnit * down); share > 0 && next > column + 1)
      found.push_back({row, column + 1, next - column - 1, share});
  }
  cells_.clear();
  return found;
}

}  // namespace loopstone
