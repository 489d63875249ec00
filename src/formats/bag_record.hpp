#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "formats/chunk_unpack.hpp"
#include "formats/little_endian.hpp"
#include "loopstone/base/stamp.hpp"

// Records of a ROS 1 bag, version 2.0: a header of fields "name=value", and data.

namespace loopstone {

inline constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";

enum class BagOp : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

/// What the fields of a header say; of each kind of record some.
struct BagFields {
  BagOp op{};
  std::optional<std::uint32_t> connection{};
  std::optional<Stamp> time{};
  std::optional<std::string_view> compression{};
  std::optional<std::string_view> topic{};
  std::uint32_t size = 0;  ///< of a chunk, unpacked
  std::uint32_t count = 0;
  std::uint64_t index_at = 0;
  std::uint64_t chunk_at = 0;
  std::uint32_t chunks = 0;
  std::uint32_t connections = 0;
  bool is_encrypted = false;
};

struct BagRecord {
  BagFields fields{};
  std::uint64_t data_at = 0;    ///< from the record's first byte
  std::uint64_t data_size = 0;  ///< as it says
  [[nodiscard]] std::uint64_t end() const { return data_at + data_size; }
};

/// Headers longer than this are damaged.
inline constexpr std::uint64_t kMostBagHeader = std::uint64_t{1} << 16;
/// The record at the front of `bytes`, of which the data may be missing. Nothing when there can't
/// be one: a header that is cut or makes no sense, or lacks what its kind must have.
[[nodiscard]] std::optional<BagRecord> read_bag_record(std::string_view bytes);

/// The fields in a header, or in a connection's data. False when it is damaged.
template <typename Use>
bool for_each_bag_field(std::string_view header, Use&& use);

/// Where the next record stands at or behind `from` that is surely one: a chunk, or a message or a
/// connection that has another record, or the end, right behind it.
/// \param last  whether nothing follows `bytes`
/// Nothing when there is none.
[[nodiscard]] std::optional<std::size_t> find_bag_record(std::string_view bytes, std::size_t from,
                                                         bool last);

template <typename Use>
bool for_each_bag_field(std::string_view header, Use&& use) {
  while (!header.empty()) {
    if (header.size() < 4) return false;
    const auto length = little_endian<std::uint32_t>(header.data());
    if (length > header.size() - 4) return false;
    const std::string_view field = header.substr(4, length);
    const std::size_t equals = field.find('=');
    if (equals == field.npos) return false;
    use(field.substr(0, equals), field.substr(equals + 1));
    header.remove_prefix(4 + std::size_t{length});
  }
  return true;
}

}  // namespace loopstone
