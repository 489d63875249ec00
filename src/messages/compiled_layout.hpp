#pragma once

#include <cstdint>
#include <string>
#include <type_traits>

#include "messages/layout.hpp"
#include "messages/wire_values.hpp"

// The layout of a message as it is compiled in.

namespace loopstone {

template <typename T>
[[nodiscard]] constexpr Kind kind_of() {
  if constexpr (std::is_same_v<T, bool>) return Kind::kBool;
  if constexpr (std::is_same_v<T, std::int8_t>) return Kind::kInt8;
  if constexpr (std::is_same_v<T, std::uint8_t>) return Kind::kUint8;
  if constexpr (std::is_same_v<T, std::int16_t>) return Kind::kInt16;
  if constexpr (std::is_same_v<T, std::uint16_t>) return Kind::kUint16;
  if constexpr (std::is_same_v<T, std::int32_t>) return Kind::kInt32;
  if constexpr (std::is_same_v<T, std::uint32_t>) return Kind::kUint32;
  if constexpr (std::is_same_v<T, std::int64_t>) return Kind::kInt64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return Kind::kUint64;
  if constexpr (std::is_same_v<T, float>) return Kind::kFloat32;
  if constexpr (std::is_same_v<T, double>) return Kind::kFloat64;
  if constexpr (std::is_same_v<T, std::string>) return Kind::kString;
  if constexpr (std::is_same_v<T, Stamp>) return Kind::kTime;
  if constexpr (std::is_same_v<T, Duration>) return Kind::kDuration;
  return Kind::kStruct;
}

template <typename M>
concept WithConstants = requires {
  Fields<M>::constants();
};

/// Visits the fields of a type and notes what they are.
struct FieldDescriber {
  WireFormat format;
  Layout& layout;
  StructLayout& type;

  template <typename T>
  void operator()(const FieldName& field, const T& /*value*/) {
    const std::string_view name = name_in(field, format);
    if (name.empty()) return;
    FieldLayout made{.name = std::string(name)};
    if constexpr (kIsVector<T>) {
      made.shape = Shape::kSequence;
      describe<typename T::value_type>(field, made);
    } else if constexpr (kIsArray<T>) {
      made.shape = Shape::kArray;
      made.count = std::tuple_size_v<T>;
      describe<typename T::value_type>(field, made);
    } else {
      describe<T>(field, made);
    }
    type.fields.push_back(std::move(made));
  }

  template <typename M>
  static std::size_t add(Layout& layout, WireFormat format) {
    for (std::size_t i = 0; i < layout.structs.size(); ++i) {
      if (layout.structs[i].name == Fields<M>::kName) return i;
    }
    StructLayout type{.name = std::string(Fields<M>::kName)};
    if constexpr (WithConstants<M>) {
      for (const MessageConstant& constant : Fields<M>::constants()) {
        const auto word = format == WireFormat::kRos1 ? constant.ros1_type : constant.ros2_type;
        if (!word.empty()) {
          type.constants.push_back(std::string(word) + " " + std::string(constant.text));
        }
      }
    }
    const M message{};
    FieldDescriber describer{format, layout, type};
    Fields<M>::visit(describer, message);
    layout.structs.push_back(std::move(type));
    return layout.structs.size() - 1;
  }

 private:
  template <typename E>
  void describe(const FieldName& field, FieldLayout& made) {
    made.kind = field.byte ? Kind::kByte : kind_of<E>();
    if constexpr (kind_of<E>() == Kind::kStruct) made.nested = add<E>(layout, format);
  }
};

template <typename M>
[[nodiscard]] Layout compiled_layout(WireFormat format) {
  Layout layout;
  layout.root = FieldDescriber::add<M>(layout, format);
  return layout;
}

}  // namespace loopstone
