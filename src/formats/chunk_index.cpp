#include "formats/chunk_index.hpp"

#include <algorithm>

namespace loopstone {

void ChunkIndex::sort() {
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const Chunk& a, const Chunk& b) { return a.at < b.at; });
}

void ChunkIndex::clear() {
  chunks_.clear();
  channels_.clear();
}

std::size_t ChunkIndex::first_from(std::uint64_t at) const {
  const auto found =
      std::lower_bound(chunks_.begin(), chunks_.end(), at,
                       [](const Chunk& chunk, std::uint64_t place) { return chunk.at < place; });
  return static_cast<std::size_t>(found - chunks_.begin());
}

const ChunkIndex::Chunk* ChunkIndex::find(std::uint64_t at) const {
  const std::size_t i = first_from(at);
  return i < chunks_.size() && chunks_[i].at == at ? &chunks_[i] : nullptr;
}

}  // namespace loopstone
