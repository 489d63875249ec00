#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/messages/message_codec.hpp"

// What a message consists of, as values: made of the compiled fields or of a definition's text.

namespace loopstone {

/// What one element of a field is. Byte, char and uint8 have the same bytes.
enum class Kind : std::uint8_t {
  kBool,
  kByte,
  kChar,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,
  kWstring,
  kTime,
  kDuration,
  kStruct,
};

struct KindWords {
  std::string_view msg;  ///< in a .msg file
  std::string_view idl;  ///< in OMG IDL
  std::size_t size;      ///< of an element [bytes]; 0: it depends on the value
  int rihs01;            ///< field type of a ROS 2 type description (type_description_interfaces)
};

/// By Kind.
inline constexpr std::array<KindWords, 18> kKinds{{
    {"bool", "boolean", 1, 15},
    {"byte", "octet", 1, 16},
    {"char", "char", 1, 13},
    {"int8", "int8", 1, 2},
    {"uint8", "uint8", 1, 3},
    {"int16", "short", 2, 4},
    {"uint16", "unsigned short", 2, 5},
    {"int32", "long", 4, 6},
    {"uint32", "unsigned long", 4, 7},
    {"int64", "long long", 8, 8},
    {"uint64", "unsigned long long", 8, 9},
    {"float32", "float", 4, 10},
    {"float64", "double", 8, 11},
    {"string", "string", 0, 17},
    {"wstring", "wstring", 0, 18},
    {"time", "", 8, 1},
    {"duration", "", 8, 1},
    {"", "", 0, 1},
}};

[[nodiscard]] constexpr const KindWords& words_of(Kind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}
[[nodiscard]] constexpr bool is_number(Kind kind) { return kind <= Kind::kFloat64; }
/// Of the kinds with the same bytes one.
[[nodiscard]] constexpr Kind bytes_of(Kind kind) {
  return kind == Kind::kByte || kind == Kind::kChar ? Kind::kUint8 : kind;
}

enum class Shape : std::uint8_t { kOne, kArray, kSequence };

struct FieldLayout {
  std::string name{};
  Kind kind = Kind::kUint8;
  Shape shape = Shape::kOne;
  std::size_t count = 0;   ///< of an array
  std::size_t nested = 0;  ///< of kStruct: its place in Layout::structs
};

struct StructLayout {
  std::string name{};  ///< canonical; may be empty for the whole message
  std::vector<std::string> constants{};
  std::vector<FieldLayout> fields{};
};

struct Layout {
  std::vector<StructLayout> structs{};
  std::size_t root = 0;

  [[nodiscard]] const StructLayout& message() const { return structs[root]; }
};

/// As names of fields are compared: CameraInfo's K of ROS 1 is k of ROS 2.
[[nodiscard]] bool same_name(std::string_view a, std::string_view b);
/// Whether both have the same bytes with the same meaning.
[[nodiscard]] bool same_layout(const Layout& a, const Layout& b);

/// What a definition has, for messages to a user: at most 60 characters, none that controls a
/// terminal.
[[nodiscard]] std::string shown(std::string_view text);

/// A field as a definition's text has it, its type by name: a word of KindWords::msg or a message.
struct ParsedField {
  std::string name{};
  std::string type{};
  Shape shape = Shape::kOne;
  std::size_t count = 0;
};
struct ParsedStruct {
  std::string name{};
  std::vector<ParsedField> fields{};
};

// Text to types, the message itself first. Throw MessageError.
[[nodiscard]] std::vector<ParsedStruct> parse_msg(std::string_view text,
                                                  DefinitionLanguage language);
/// The part of OMG IDL that the interfaces of ROS 2 are written in.
[[nodiscard]] std::vector<ParsedStruct> parse_idl(std::string_view text);
/// Puts types in place of their names. Everything in the result has at least one byte, but for
/// sequences: types without fields have the byte that ROS 2 gives them, or vanish in ROS 1. Throws
/// MessageError for types that are missing, contain themselves, or nest deeper than 32.
[[nodiscard]] Layout link_types(const std::vector<ParsedStruct>& types, WireFormat format);
/// All of that. Throws MessageError also for kNone and a text of more than 1 MiB.
[[nodiscard]] Layout parse_definition(WireFormat format, const MessageDefinition& definition);

/// The field that ROS 2 puts into a type without any.
inline constexpr std::string_view kDummyField = "structure_needs_at_least_one_member";

}  // namespace loopstone
