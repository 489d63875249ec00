#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/chunk_index.hpp"
#include "formats/chunk_unpack.hpp"
#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"
#include "formats/recording_bytes.hpp"

namespace loopstone {

/// What a record's head tells. Places count from the record's first byte.
struct RecordHead {
  enum class Kind {
    kOther,
    kMessage,
    kTopic,  ///< describes topics
    kChunk,
  };

  Kind kind = Kind::kOther;
  std::uint8_t op = 0;     ///< the kind as the format counts
  std::uint64_t head = 0;  ///< where the next record may be at the earliest, if this is none
  std::uint64_t data = 0;  ///< of a message: where its bytes begin
  std::uint64_t end = 0;   ///< as it says
  std::uint32_t channel = 0;
  Stamp recorded{};
};

/// A chunk in the file.
struct ChunkHead {
  std::optional<Packing> packing{};  ///< none: one that is not known
  std::uint64_t unpacked_size = 0;   ///< as it says
  std::uint32_t checksum = 0;        ///< of the unpacked bytes; 0: none
  std::uint64_t at = 0;
  std::uint64_t data = 0;         ///< where what is packed begins
  std::uint64_t stated_size = 0;  ///< bytes that it says are packed
  std::uint64_t stored_size = 0;  ///< bytes of these that are there
  std::uint64_t end = 0;          ///< where the next record is
  bool fits = false;              ///< its record has the place that it says

  [[nodiscard]] bool is_cut() const { return stored_size < stated_size; }
};

/// A file of records, one behind the other, that stand in chunks or between them; an index may tell
/// where the chunks are and what they hold. How to go from one to the next, past damage, too, is
/// the same whatever they look like. What they look like is the format's.
class ChunkedRecording : public Recording {
 public:
  [[nodiscard]] const std::vector<RecordedTopic>& topics() const final { return topics_.all(); }
  [[nodiscard]] bool is_indexed() const final { return is_indexed_; }
  void want(std::function<bool(const RecordedTopic&)> wanted) final {
    topics_.want(std::move(wanted));
  }
  [[nodiscard]] std::optional<RecordedMessage> next() final;
  [[nodiscard]] std::span<const char> bytes_at(const MessagePlace& place) final;
  void rewind() final {
    damage_.begin_again();
    begin();
  }
  [[nodiscard]] ReadProgress progress() const final;

 protected:
  /// \param first  where the first record is
  ChunkedRecording(std::unique_ptr<RecordingBytes> bytes, const RecordingOptions& options,
                   std::uint64_t first);

  // What a format tells of its records.

  /// Of the record at the front of `bytes`, of which the end may be missing. Nothing when there is
  /// none.
  [[nodiscard]] virtual std::optional<RecordHead> read_record(std::string_view bytes) const = 0;
  /// The same in the file. Until the next view of it.
  [[nodiscard]] virtual std::optional<RecordHead> record_at(std::uint64_t at) = 0;
  /// Whether a record may be followed by what stands behind it in a chunk.
  [[nodiscard]] virtual bool is_followed_well(const RecordHead& /*record*/,
                                              std::string_view /*behind*/) const {
    return true;
  }
  /// Whether a record that ends there may be believed, by what follows.
  [[nodiscard]] virtual bool ends_well(std::uint64_t end) = 0;
  /// The next record that surely is one.
  [[nodiscard]] virtual std::optional<std::size_t> find_record(std::string_view bytes,
                                                               std::size_t from,
                                                               bool last) const = 0;
  [[nodiscard]] virtual bool is_chunk(std::uint64_t at) = 0;
  /// Nothing when there is no chunk.
  [[nodiscard]] virtual std::optional<ChunkHead> chunk_at(std::uint64_t at) = 0;
  /// What is wrong with a chunk that could be unpacked; empty when nothing is.
  [[nodiscard]] virtual std::string fault_of(const ChunkHead& chunk,
                                             std::string_view unpacked) const = 0;
  [[nodiscard]] virtual std::optional<std::size_t> topic_of(std::uint32_t channel) const = 0;
  /// Takes a topic from a record that describes it. False when that is damaged.
  [[nodiscard]] virtual bool describe(const RecordHead& record, std::string_view bytes) = 0;

  // Between the chunks.

  /// To the first record, and to what was known before it.
  virtual void begin();
  /// Uses the record at at_ and goes behind it.
  [[nodiscard]] virtual std::optional<RecordedMessage> step() = 0;
  /// What stands at at_ is no record. Goes on where the next one is found, at the next chunk that
  /// the index knows of at the latest.
  virtual void pass_damage(const std::string& reason);
  virtual void go_on_from(std::uint64_t place);
  /// Where a record ends that says that it ends at `end`: before the next chunk, if the index knows
  /// of one that is really there.
  [[nodiscard]] std::uint64_t end_before_next_chunk(std::uint64_t at, std::uint64_t end);
  [[nodiscard]] std::optional<std::uint64_t> find_chunk_from(std::uint64_t at);
  /// Of the two ends of a chunk that does not agree with itself, the one behind which there is a
  /// record.
  [[nodiscard]] std::uint64_t end_of_chunk(std::uint64_t end, std::uint64_t other_end);
  /// The one at at_.
  void open_chunk();
  /// Of a record that is whole.
  [[nodiscard]] std::optional<RecordedMessage> use_record(const RecordHead& record,
                                                          std::uint64_t at);

  std::unique_ptr<RecordingBytes> bytes_;
  RecordedTopics topics_;
  ToldDamage damage_;
  ChunkIndex index_{};
  bool is_indexed_ = false;
  std::uint64_t data_end_;  ///< of the records that hold messages
  std::uint64_t at_;        ///< of the next record
  std::uint64_t resume_;    ///< from where on to search when there is none

 private:
  [[nodiscard]] std::optional<std::uint64_t> search(std::uint64_t from, std::uint64_t limit);
  [[nodiscard]] bool may_be_skipped(std::uint64_t at) const;
  [[nodiscard]] UnpackedChunk unpack(ChunkUnpacker& unpacker, const ChunkHead& chunk);
  [[nodiscard]] std::optional<RecordedMessage> next_in_chunk();
  [[nodiscard]] bool pass_damage_in_chunk();
  [[nodiscard]] std::optional<RecordedMessage> use(const RecordHead& record, std::string_view bytes,
                                                   MessagePlace place);
  [[nodiscard]] std::string_view bytes_from(const MessagePlace& place);

  MemoryBudget memory_;
  std::uint64_t first_;
  ChunkUnpacker unpacker_{};
  const std::function<void()> stop_ = [this] { bytes_->ask_stop(); };

  bool in_chunk_ = false;
  bool is_displaced_ = false;  ///< bytes_at() took the buffer of a chunk that is not packed
  bool told_chunk_ = false;    ///< that it is damaged
  std::string_view chunk_{};
  std::size_t in_chunk_at_ = 0;
  std::size_t in_chunk_resume_ = 0;  ///< from where on to search when there is no record
  std::uint64_t chunk_at_ = 0;       ///< of its record in the file
  std::uint64_t chunk_data_ = 0;     ///< of its bytes in the file, when it is not packed; else 0

  // What was last unpacked for bytes_at().
  ChunkUnpacker placed_unpacker_{};
  std::uint64_t placed_at_ = 0;  ///< 0: nothing
  std::string_view placed_chunk_{};
};

}  // namespace loopstone
