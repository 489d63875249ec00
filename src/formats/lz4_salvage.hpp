#pragma once

#include <cstddef>
#include <string_view>

namespace loopstone {

struct SalvagedBlock {
  std::size_t used = 0;   ///< bytes that are there now
  bool is_whole = false;  ///< it ended as blocks end
};

/// Unpacks a bare block of LZ4 up to where it is cut or damaged, behind the bytes that earlier
/// blocks of the same frame have made and to which it may refer.
/// \param out       the beginning of what is unpacked; `used` bytes of it are there
/// \param capacity  of `out`
[[nodiscard]] SalvagedBlock salvage_lz4_block(std::string_view packed, char* out, std::size_t used,
                                              std::size_t capacity);

/// The same of a frame of LZ4 that is cut or damaged, without looking at its checksums. Writes only
/// what fits into `capacity`.
[[nodiscard]] std::size_t salvage_lz4_frame(std::string_view packed, char* out,
                                            std::size_t capacity);

}  // namespace loopstone
