#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

/// A named part of a saved state.
struct StateChunk {
  std::string tag;            ///< four characters
  std::uint16_t version = 1;  ///< of the field list that its bytes follow
  bool optional = false;      ///< who does not know it may leave it out
  std::string bytes{};
  Location origin{};  ///< of its first byte, for errors
};

/// An object's fields as a chunk.
template <typename Object>
[[nodiscard]] StateChunk save_chunk(std::string tag, std::uint16_t version, const Object& object) {
  ByteWriter writer;
  writer(object);
  return {.tag = std::move(tag), .version = version, .bytes = writer.take()};
}

/// Puts an object's fields back. Throws DataError when there is no such chunk, when it is of
/// another version, or damaged; the object is of no use then.
template <typename Object>
void load_chunk(std::span<const StateChunk> chunks, std::string_view tag, std::uint16_t version,
                Object& object) {
  const auto chunk = std::ranges::find(chunks, tag, &StateChunk::tag);
  const std::string name = "part " + std::string(tag);
  if (chunk == chunks.end()) {
    throw DataError({chunks.empty() ? "" : chunks.front().origin.path}, name + " is missing");
  }
  if (chunk->version != version) {
    throw DataError(chunk->origin, name + " is of version " + std::to_string(chunk->version) +
                                       "; this program knows version " + std::to_string(version));
  }
  ByteReader reader(chunk->bytes, chunk->origin);
  reader(object);
  reader.end();
}

/// Refuses chunks whose tags are not among these, unless they may be left out. Throws DataError.
inline void refuse_unknown(std::span<const StateChunk> chunks,
                           std::span<const std::string_view> known) {
  for (const StateChunk& chunk : chunks) {
    if (chunk.optional || std::ranges::find(known, chunk.tag) != known.end()) continue;
    throw DataError(chunk.origin, "part " + chunk.tag + " is not known to this program");
  }
}

}  // namespace loopstone
