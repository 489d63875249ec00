#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "formats/recorded_topics.hpp"

namespace loopstone {

/// The topics of MCAP's channels, as its schemas and channels tell them. A value: what was known at
/// one place of the file can be taken up again.
class McapTopics {
 public:
  McapTopics() : topic_of_(std::size_t{1} << 16U, kNone) {}

  // Of what stands behind a record's head; false when that is damaged. What is new is added to
  // `topics`.

  /// \param keep  one that is known already stays as it is
  bool add_schema(std::string_view fields, bool keep, RecordedTopics& topics);
  bool add_channel(std::string_view fields, bool keep, RecordedTopics& topics);

  [[nodiscard]] bool knows_schema(std::uint16_t schema) const { return schemas_.contains(schema); }
  [[nodiscard]] bool knows_channel(std::uint32_t channel) const {
    return topic_of_[channel] != kNone;
  }
  [[nodiscard]] std::optional<std::size_t> topic_of(std::uint32_t channel) const;
  [[nodiscard]] std::size_t channels() const;

 private:
  /// That channels may still refer to.
  struct Schema {
    std::string type{};
    MessageDefinition definition{};
  };
  static constexpr std::int32_t kNone = -1;

  std::vector<std::int32_t> topic_of_;  ///< by the channel
  std::unordered_map<std::uint16_t, Schema> schemas_{};
};

}  // namespace loopstone
