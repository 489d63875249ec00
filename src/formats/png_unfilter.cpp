#include "formats/png_unfilter.hpp"

#include <array>
#include <cstdlib>
#include <vector>

namespace loopstone {
namespace {

// Each filter for a number of bytes a pixel, which the compiler knows: the pixel to the left stays
// in registers.

template <std::size_t kBytes>
void undo_sub(std::uint8_t* row, std::size_t size) {
  std::array<std::uint8_t, kBytes> left{};
  for (std::size_t at = 0; at < size; at += kBytes) {
    for (std::size_t i = 0; i < kBytes; ++i) {
      left[i] = static_cast<std::uint8_t>(left[i] + row[at + i]);
      row[at + i] = left[i];
    }
  }
}

void undo_up(std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
}

template <std::size_t kBytes>
void undo_average(std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  std::array<unsigned, kBytes> left{};
  for (std::size_t at = 0; at < size; at += kBytes) {
    for (std::size_t i = 0; i < kBytes; ++i) {
      left[i] = (row[at + i] + (left[i] + above[at + i]) / 2U) & 0xffU;
      row[at + i] = static_cast<std::uint8_t>(left[i]);
    }
  }
}

template <std::size_t kBytes>
void undo_paeth(std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  std::array<int, kBytes> left{};
  std::array<int, kBytes> above_left{};
  for (std::size_t at = 0; at < size; at += kBytes) {
    for (std::size_t i = 0; i < kBytes; ++i) {
      const int up = above[at + i];
      // Distances of left + up - above_left to each of the three.
      const int to_left = up - above_left[i];
      const int to_up = left[i] - above_left[i];
      const int far_left = std::abs(to_left);
      const int far_up = std::abs(to_up);
      const int far_corner = std::abs(to_left + to_up);
      // Ties: left before up before the corner. Without branches, which noise would make
      // unpredictable.
      const int nearer = far_up <= far_corner ? up : above_left[i];
      const int least = far_up <= far_corner ? far_up : far_corner;
      const int guess = far_left <= least ? left[i] : nearer;
      left[i] = (row[at + i] + guess) & 0xff;
      above_left[i] = up;
      row[at + i] = static_cast<std::uint8_t>(left[i]);
    }
  }
}

template <std::size_t kBytes>
bool unfilter(std::uint8_t* rows, std::size_t row_bytes, std::size_t height) {
  const std::vector<std::uint8_t> nothing(row_bytes, 0);
  const std::uint8_t* above = nothing.data();
  for (std::size_t row = 0; row < height; ++row) {
    std::uint8_t* const filter = rows + row * (row_bytes + 1);
    std::uint8_t* const pixels = filter + 1;
    switch (*filter) {
      case 0:
        break;
      case 1:
        undo_sub<kBytes>(pixels, row_bytes);
        break;
      case 2:
        undo_up(pixels, above, row_bytes);
        break;
      case 3:
        undo_average<kBytes>(pixels, above, row_bytes);
        break;
      case 4:
        undo_paeth<kBytes>(pixels, above, row_bytes);
        break;
      default:
        return false;
    }
    above = pixels;
  }
  return true;
}

}  // namespace

bool unfilter_png(std::uint8_t* rows, std::size_t row_bytes, std::size_t height,
                  std::size_t bytes_per_pixel) {
  switch (bytes_per_pixel) {
    case 1:
      return unfilter<1>(rows, row_bytes, height);
    case 2:
      return unfilter<2>(rows, row_bytes, height);
    case 3:
      return unfilter<3>(rows, row_bytes, height);
    case 4:
      return unfilter<4>(rows, row_bytes, height);
    case 6:
      return unfilter<6>(rows, row_bytes, height);
    case 8:
      return unfilter<8>(rows, row_bytes, height);
    default:
      return false;
  }
}

}  // namespace loopstone
