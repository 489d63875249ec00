#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace loopstone {

/// Where the chunks of a recording stand and what they hold, as its index says.
class ChunkIndex {
 public:
  struct Chunk {
    std::uint64_t at = 0;
    std::size_t first = 0;     ///< of its channels, in channels()
    std::size_t channels = 0;  ///< none: what it holds is not known
  };

  void add(std::uint64_t at) { chunks_.push_back({at, channels_.size(), 0}); }
  /// To the chunk that was added last.
  void add_channel(std::uint32_t channel) {
    channels_.push_back(channel);
    ++chunks_.back().channels;
  }
  /// Once all are added.
  void sort();
  void clear();

  [[nodiscard]] std::size_t size() const { return chunks_.size(); }
  [[nodiscard]] const std::vector<Chunk>& chunks() const { return chunks_; }
  [[nodiscard]] const std::vector<std::uint32_t>& channels() const { return channels_; }
  /// The one at this place; none when there is none.
  [[nodiscard]] const Chunk* find(std::uint64_t at) const;
  /// Where the first chunk stands of those in [from, end) that are really there.
  /// \param is_there  asked for the places that the index tells
  template <typename IsThere>
  [[nodiscard]] std::optional<std::uint64_t> first_in(std::uint64_t from, std::uint64_t end,
                                                      IsThere&& is_there) const {
    for (std::size_t i = first_from(from); i < chunks_.size() && chunks_[i].at < end; ++i) {
      if (is_there(chunks_[i].at)) return chunks_[i].at;
    }
    return std::nullopt;
  }
  /// In chunks(), the first at or behind a place.
  [[nodiscard]] std::size_t first_from(std::uint64_t at) const;

 private:
  std::vector<Chunk> chunks_{};
  std::vector<std::uint32_t> channels_{};
};

}  // namespace loopstone
