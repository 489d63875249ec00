#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "formats/recording_bytes.hpp"

namespace loopstone {

/// How a recording packs its chunks.
enum class Packing { kNone, kBzip2, kLz4, kZstd };

/// Of the words that recordings use: "", "none", "bz2", "lz4", "zstd".
[[nodiscard]] std::optional<Packing> packing_of(std::string_view word);

struct UnpackedChunk {
  std::string_view bytes{};    ///< until the next call of the unpacker
  std::uint64_t consumed = 0;  ///< of the stored bytes
  std::string damage{};        ///< why there is no more; empty when all is there
};

/// Unpacks one chunk after another into the same memory, which grows with what comes out, not with
/// what a file says about itself. What stands before damage is unpacked all the same, whatever
/// was unpacked before.
class ChunkUnpacker {
 public:
  ChunkUnpacker();
  ~ChunkUnpacker();
  ChunkUnpacker(const ChunkUnpacker&) = delete;
  ChunkUnpacker& operator=(const ChunkUnpacker&) = delete;

  /// \param stored       the chunk, or the beginning of one that was cut
  /// \param stated_size  unpacked, as the file says: a hint, but for a bare block of LZ4
  /// \param most_bytes   more than these are damage
  /// \param stop         asked between blocks; throws when there shall be no more
  [[nodiscard]] UnpackedChunk unpack(Packing packing, std::string_view stored,
                                     std::uint64_t stated_size, std::uint64_t most_bytes,
                                     const std::function<void()>& stop);

 private:
  struct Job;
  struct Contexts;

  [[nodiscard]] UnpackedChunk unpack_bzip2(const Job& job);
  [[nodiscard]] UnpackedChunk unpack_lz4(const Job& job);
  [[nodiscard]] UnpackedChunk unpack_lz4_block(const Job& job);
  [[nodiscard]] std::size_t salvage_lz4(const Job& job);
  [[nodiscard]] UnpackedChunk unpack_zstd(const Job& job);
  [[nodiscard]] UnpackedChunk salvage_zstd(const Job& job);
  [[nodiscard]] bool make_room(std::size_t used, const Job& job);

  RawBuffer buffer_{};
  std::unique_ptr<Contexts> contexts_;
};

}  // namespace loopstone
