#include "loopstone/grid/max_pyramid.hpp"

#include <algorithm>

namespace loopstone {

namespace {

/// out[i] = max(in[i], in[i + shift]), with `outside` past the end.
void maximum_of_shifted(const std::uint8_t* in, std::uint8_t* out, std::size_t count,
                        std::size_t shift, std::uint8_t outside) {
  const std::size_t inner = count > shift ? count - shift : 0;
  for (std::size_t i = 0; i < inner; ++i) out[i] = std::max(in[i], in[i + shift]);
  for (std::size_t i = inner; i < count; ++i) out[i] = std::max(in[i], outside);
}

}  // namespace

MaxPyramid::MaxPyramid(const Grid<std::uint8_t>& grid, int levels, std::uint8_t outside)
    : frame_(grid.frame()),
      margin_((1 << (levels - 1)) - 1),
      columns_(static_cast<unsigned>(frame_.columns + margin_)),
      rows_(static_cast<unsigned>(frame_.rows + margin_)),
      outside_(outside) {
  const std::size_t columns = columns_;
  const std::size_t rows = rows_;
  std::vector<std::uint8_t> base(columns * rows, outside);
  for (int row = 0; row < frame_.rows; ++row) {
    std::copy_n(
        grid.cells().begin() + static_cast<std::ptrdiff_t>(row) * frame_.columns, frame_.columns,
        base.begin() +
            static_cast<std::ptrdiff_t>(row + margin_) * static_cast<std::ptrdiff_t>(columns) +
            margin_);
  }
  levels_.push_back(std::move(base));
  std::vector<std::uint8_t> along_rows(columns * rows);
  const std::vector<std::uint8_t> nothing(columns, outside);
  for (int level = 1; level < levels; ++level) {
    const std::size_t shift = std::size_t{1} << (level - 1);
    const auto& below = levels_.back();
    for (std::size_t row = 0; row < rows; ++row) {
      maximum_of_shifted(&below[row * columns], &along_rows[row * columns], columns, shift,
                         outside);
    }
    std::vector<std::uint8_t> next(columns * rows);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::uint8_t* upper =
          row + shift < rows ? &along_rows[(row + shift) * columns] : nothing.data();
      const std::uint8_t* lower = &along_rows[row * columns];
      std::uint8_t* out = &next[row * columns];
      for (std::size_t column = 0; column < columns; ++column)
        out[column] = std::max(lower[column], upper[column]);
    }
    levels_.push_back(std::move(next));
  }
}

}  // namespace loopstone
