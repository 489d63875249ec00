#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "formats/little_endian.hpp"
#include "loopstone/base/stamp.hpp"

// Records of an MCAP file: a kind, a length, and fields without names.

namespace loopstone {

inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kAttachment = 9,
  kAttachmentIndex = 10,
  kStatistics = 11,
  kMetadata = 12,
  kMetadataIndex = 13,
  kSummaryOffset = 14,
  kDataEnd = 15,
};

/// Of a record's kind and length.
inline constexpr std::uint64_t kMcapHead = 9;

struct McapRecord {
  McapOp op{};
  std::uint64_t length = 0;  ///< as it says
  /// From its first byte; the greatest number when that does not fit.
  [[nodiscard]] std::uint64_t end() const {
    return length > ~kMcapHead ? ~std::uint64_t{0} : kMcapHead + length;
  }
};

/// Takes fields from the front of a record. After one that is cut all are empty, and is_good() is
/// false.
class McapFields {
 public:
  explicit McapFields(std::string_view bytes) : left_(bytes) {}

  template <typename T>
  [[nodiscard]] T number() {
    const std::string_view bytes = take(sizeof(T));
    return bytes.empty() ? T{0} : little_endian<T>(bytes.data());
  }
  [[nodiscard]] std::string_view take(std::uint64_t count) {
    good_ = good_ && count <= left_.size();
    if (!good_) return {};
    const std::string_view bytes = left_.substr(0, static_cast<std::size_t>(count));
    left_.remove_prefix(static_cast<std::size_t>(count));
    return bytes;
  }
  /// Text, bytes or a map, behind their length.
  [[nodiscard]] std::string_view text() { return take(number<std::uint32_t>()); }
  [[nodiscard]] bool is_good() const { return good_; }
  [[nodiscard]] std::string_view left() const { return left_; }

 private:
  std::string_view left_;
  bool good_ = true;
};

struct McapSchema {
  std::uint16_t id = 0;
  std::string_view name{};
  std::string_view encoding{};
  std::string_view text{};
};
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;
  std::string_view topic{};
  std::string_view encoding{};
  std::string_view metadata{};
};
struct McapMessage {
  std::uint16_t channel = 0;
  Stamp recorded{};
  std::string_view bytes{};
};
struct McapChunk {
  std::uint64_t unpacked_size = 0;
  std::uint32_t checksum = 0;
  std::string_view compression{};
  std::uint64_t data = 0;  ///< where the packed records begin, from behind the chunk's own head
  std::uint64_t data_size = 0;
};

// Of what stands behind a record's head. Nothing when it is cut.
[[nodiscard]] std::optional<McapSchema> read_mcap_schema(std::string_view bytes);
[[nodiscard]] std::optional<McapChannel> read_mcap_channel(std::string_view bytes);
[[nodiscard]] std::optional<McapMessage> read_mcap_message(std::string_view bytes);
/// The records in it may be missing.
[[nodiscard]] std::optional<McapChunk> read_mcap_chunk(std::string_view bytes);
/// Enough bytes for read_mcap_chunk().
inline constexpr std::uint64_t kMostMcapChunkHead = 128;

/// The value of a name in a map of texts; empty when it has none.
[[nodiscard]] std::string_view mcap_map_value(std::string_view map, std::string_view name);

/// The head at the front. Nothing when there is no kind 0, or the length is less than the kind has.
[[nodiscard]] std::optional<McapRecord> read_mcap_head(std::string_view bytes);

/// Whether a record of this kind may have the other behind it, as far as that can be told. Kinds
/// that are not known yet are taken for damage unless a known one, or one of the same kind,
/// follows: a head that is read at a wrong place often looks like one of them.
[[nodiscard]] bool may_follow(McapOp op, const std::optional<McapRecord>& next);

/// Where the next record stands at or behind `from` that is surely one: a chunk that agrees with
/// itself, or a schema, channel or message with another record, or the end, right behind it.
/// \param knows_channel  whether a message may be of this channel
/// \param last           whether nothing follows `bytes`
[[nodiscard]] std::optional<std::size_t> find_mcap_record(
    std::string_view bytes, std::size_t from, bool last,
    const std::function<bool(std::uint16_t)>& knows_channel);

}  // namespace loopstone
