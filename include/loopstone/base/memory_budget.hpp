#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "loopstone/base/error.hpp"

namespace loopstone {

/// How many bytes of memory a byte of an honest file may become. Packed files can make far more;
/// what is beyond these is taken for a trap, or at least worth a question.
enum class Growth : std::uint64_t {
  kNumbers = 256,   ///< arrays and clouds: packed small integers that become doubles
  kPicture = 2048,  ///< pictures: Deflate makes a thousand bytes of one where nothing changes
  kMap = 8192,      ///< maps with what is computed for each of their cells
};

/// How much memory what one file holds may take: 128 MiB for any file, beyond that so many times
/// its size, and never more than the ceiling. Readers ask before they allocate. A value: it travels
/// as an argument.
struct MemoryBudget {
  /// Any file may take so much.
  static constexpr std::uint64_t kSmall = std::uint64_t{1} << 27;

  /// A byte of text becomes at most so many: "0 0 0 0 0 0 0 0" a pose, "EDGE_SE2 1 2 ..." an edge.
  static constexpr std::uint64_t kTextGrowth = 8;

  std::uint64_t ceiling_bytes = std::uint64_t{1} << 34;
  bool by_file_size = true;  ///< false: whoever set the ceiling knows better

  /// For a file of that size.
  [[nodiscard]] std::uint64_t allowed_bytes(std::uint64_t file_bytes, Growth growth) const;
  /// The largest text whose tables fit.
  [[nodiscard]] std::size_t most_text_bytes() const { return ceiling_bytes / kTextGrowth; }
  /// Throws DataError at `where` when that many bytes are more than the file may take; it says how
  /// to allow them.
  void require(std::uint64_t needed_bytes, std::uint64_t file_bytes, Growth growth,
               const Location& where) const;
};

/// The product, or the greatest number when it does not fit.
[[nodiscard]] constexpr std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return a != 0 && b > kMost / a ? kMost : a * b;
}

/// A count of bytes as people write it: "34 kB", "7.7 GB", "16 EB". Powers of 1000.
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);

/// What people write: "2G", "512M", "1.5GB", "2GiB", "800000"; K, M, G, T are powers of 1024.
/// Throws UsageError for anything else, and for less than 16 MiB.
[[nodiscard]] std::uint64_t parse_bytes(std::string_view text);

}  // namespace loopstone
