#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/messages/message_types.hpp"

// The bytes of messages. Two serialisations: ROS 1's, packed and little-endian, and CDR of ROS 2
// (XCDR version 1, either byte order). A message's layout is described once, by its fields; from it
// follow both serialisations, the definition's text, ROS 1's MD5 and ROS 2's RIHS01 hash.

namespace loopstone {

enum class WireFormat { kRos1, kCdr };

/// In what language a definition is written.
enum class DefinitionLanguage { kNone, kRos1Msg, kRos2Msg, kRos2Idl };

/// What a recording says of a type: its text, with those of the types that it uses behind it, each
/// after a line of 80 '=' and one of "MSG: package/Name".
struct MessageDefinition {
  DefinitionLanguage language = DefinitionLanguage::kNone;
  std::string text{};
};

/// The bytes are not a message of this type.
class MessageError : public std::runtime_error {
 public:
  MessageError(std::size_t offset, const std::string& reason)
      : std::runtime_error(reason), offset_(offset) {}
  /// In the message's bytes.
  [[nodiscard]] std::size_t offset() const { return offset_; }

 private:
  std::size_t offset_;
};

/// "sensor_msgs/LaserScan" of "sensor_msgs/LaserScan", "sensor_msgs/msg/LaserScan" and
/// "sensor_msgs::msg::dds_::LaserScan_"; the text itself when it is none of these. "tf/tfMessage"
/// becomes "tf2_msgs/TFMessage".
[[nodiscard]] std::string canonical_type(std::string_view type);
/// "sensor_msgs/msg/LaserScan" of "sensor_msgs/LaserScan".
[[nodiscard]] std::string ros2_type(std::string_view canonical);

/// Everything about one known type that does not need its values. `M` is a struct of
/// message_types.hpp (any that can be a topic's type or part of one).
template <typename M>
struct MessageType {
  [[nodiscard]] static std::string name();             ///< "sensor_msgs/LaserScan"
  [[nodiscard]] static std::string ros1_definition();  ///< whole, without comments
  [[nodiscard]] static std::string ros2_definition();
  [[nodiscard]] static std::string md5();     ///< of ROS 1: 32 hexadecimal digits
  [[nodiscard]] static std::string rihs01();  ///< of ROS 2: "RIHS01_" and 64 hexadecimal digits
};

/// Reads messages of one topic. When the topic's own definition differs from what is compiled in,
/// it decodes by that definition: fields are found by their names, numbers are converted, fields
/// that the definition lacks keep their defaults, fields that nobody asks for are passed over.
template <typename M>
class MessageDecoder {
 public:
  /// Throws MessageError when the definition can't be understood, has none of the fields, or has
  /// one that can't be converted. A definition in IDL that can't be understood counts as none.
  explicit MessageDecoder(WireFormat format, const MessageDefinition& definition = {});
  ~MessageDecoder();
  MessageDecoder(MessageDecoder&&) noexcept;
  MessageDecoder& operator=(MessageDecoder&&) noexcept;

  /// Vectors of `message` are used again when it decodes as compiled. Throws MessageError with the
  /// offset, also for bytes behind the message, but for padding of CDR; memory is taken only for
  /// what the bytes can hold.
  void decode(std::span<const char> bytes, M& message) const;
  /// False when it goes by the topic's own definition.
  [[nodiscard]] bool as_compiled() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The bytes of a message; CDR little-endian with its 4 bytes of encapsulation. `bytes` is
/// replaced. Throws MessageError for stamps that no message holds: before 1970 in ROS 1, after 2038
/// in ROS 2.
template <typename M>
void encode_message(WireFormat format, const M& message, std::string& bytes);

/// A message of a type that is known by its definition alone, as paths and values: "header.stamp",
/// "left.counts[2]". Numbers are doubles (64-bit integers beyond 2^53 lose digits); durations are
/// numbers, in seconds. Of a message with more values the first 20,000 are told.
class AnyMessageDecoder {
 public:
  /// Throws MessageError when the definition can't be understood.
  AnyMessageDecoder(WireFormat format, const MessageDefinition& definition);
  ~AnyMessageDecoder();
  AnyMessageDecoder(AnyMessageDecoder&&) noexcept;
  AnyMessageDecoder& operator=(AnyMessageDecoder&&) noexcept;

  struct Values {
    std::map<std::string, double, std::less<>> numbers{};
    std::map<std::string, std::string, std::less<>> strings{};
    std::map<std::string, Stamp, std::less<>> stamps{};
  };
  /// \param most_elements  of arrays so many are told, the others are passed over
  [[nodiscard]] Values decode(std::span<const char> bytes, std::size_t most_elements = 64) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A message as readable bytes without decoding the rest: the header's stamp and frame of any
/// message whose first field is a std_msgs/Header. Nothing when the bytes are too short.
[[nodiscard]] std::optional<msg::Header> decode_header(WireFormat format,
                                                       std::span<const char> bytes);

}  // namespace loopstone
