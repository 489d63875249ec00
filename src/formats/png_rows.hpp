#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "formats/atomic_file.hpp"

namespace loopstone {

/// Puts width * channels samples of a row into the span; rows come from the top, 0, down.
using FillRow = std::function<void(int row, std::span<std::uint8_t> samples)>;

/// As write_png_rows of image.hpp, into a file that somebody else commits.
void write_png_rows(AtomicFile& file, int width, int height, int channels, const FillRow& fill_row,
                    int compression);

}  // namespace loopstone
