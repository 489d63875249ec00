#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "messages/compiled_layout.hpp"
#include "messages/layout.hpp"
#include "messages/wire_values.hpp"

// Messages by a definition that is not the compiled one: fields by their names, numbers converted.

namespace loopstone {

/// The nearest that T holds; 0 for no number in place of a whole one.
template <typename T, typename From>
[[nodiscard]] T converted(From value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value != From{};
  } else if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else if constexpr (std::is_floating_point_v<From>) {
    // The ends as powers of 2, which a double holds.
    constexpr double kEnd = 2.0 * static_cast<double>(std::numeric_limits<T>::max() / 2 + 1);
    if (std::isnan(value)) return 0;
    if (static_cast<double>(value) >= kEnd) return std::numeric_limits<T>::max();
    if (static_cast<double>(value) <= static_cast<double>(std::numeric_limits<T>::min())) {
      return std::numeric_limits<T>::min();
    }
    return static_cast<T>(value);
  } else if constexpr (std::is_same_v<From, bool>) {
    return value ? 1 : 0;
  } else {
    if (std::cmp_greater(value, std::numeric_limits<T>::max()))
      return std::numeric_limits<T>::max();
    if (std::cmp_less(value, std::numeric_limits<T>::min())) return std::numeric_limits<T>::min();
    return static_cast<T>(value);
  }
}

/// The next number, of a kind that is_number().
template <typename T>
[[nodiscard]] T read_number(WireReader& in, Kind kind) {
  switch (bytes_of(kind)) {
    case Kind::kBool:
      return converted<T>(in.number<bool>());
    case Kind::kInt8:
      return converted<T>(in.number<std::int8_t>());
    case Kind::kInt16:
      return converted<T>(in.number<std::int16_t>());
    case Kind::kUint16:
      return converted<T>(in.number<std::uint16_t>());
    case Kind::kInt32:
      return converted<T>(in.number<std::int32_t>());
    case Kind::kUint32:
      return converted<T>(in.number<std::uint32_t>());
    case Kind::kInt64:
      return converted<T>(in.number<std::int64_t>());
    case Kind::kUint64:
      return converted<T>(in.number<std::uint64_t>());
    case Kind::kFloat32:
      return converted<T>(in.number<float>());
    case Kind::kFloat64:
      return converted<T>(in.number<double>());
    default:
      return converted<T>(in.number<std::uint8_t>());
  }
}

/// A string of either width.
[[nodiscard]] std::string read_text(WireReader& in, Kind kind);
/// How many elements follow. 0 for a sequence of types without bytes.
[[nodiscard]] std::size_t read_count(WireReader& in, const Layout& layout,
                                     const FieldLayout& field);
/// Passes over so many elements of a field.
void skip_elements(WireReader& in, const Layout& layout, const FieldLayout& field,
                   std::size_t count);

/// Reads one type of a definition's layout into a compiled one.
class DefinedReader {
 public:
  DefinedReader(WireReader& in, const Layout& layout) : in_(in), layout_(layout) {}

  template <typename M>
  void read_struct(std::size_t type, M& message) {
    for (const FieldLayout& field : layout_.structs[type].fields) {
      bool found = false;
      const auto take = [&]<typename T>(const FieldName& name, T& value) {
        if (found || !is_called(field, name)) return;
        found = true;
        read_field(field, value);
      };
      Fields<M>::visit(take, message);
      if (!found) skip_elements(in_, layout_, field, read_count(in_, layout_, field));
    }
  }

  [[nodiscard]] static bool is_called(const FieldLayout& field, const FieldName& name) {
    return same_name(field.name, name.ros1) || same_name(field.name, name.ros2);
  }

 private:
  template <typename T>
  void read_field(const FieldLayout& field, T& value) {
    if constexpr (kIsVector<T>) {
      read_vector(field, value);
    } else if constexpr (kIsArray<T>) {
      const std::size_t count = read_count(in_, layout_, field);
      const std::size_t kept = std::min(count, value.size());
      for (std::size_t i = 0; i < kept; ++i) read_element(field, value[i]);
      skip_elements(in_, layout_, field, count - kept);
    } else {
      read_element(field, value);
    }
  }

  template <typename E>
  void read_vector(const FieldLayout& field, std::vector<E>& values) {
    const std::size_t count = read_count(in_, layout_, field);
    values.clear();
    if constexpr (std::is_arithmetic_v<E>) {
      values.resize(count);
      if (bytes_of(field.kind) == bytes_of(kind_of<E>())) return in_.numbers(std::span(values));
      for (E& value : values) read_element(field, value);
    } else {
      // A definition may leave a type so little that millions of them fit into a small message.
      constexpr std::size_t kMostGrowth = 64;
      if (count > kMostGrowth * in_.size() / sizeof(E)) {
        throw MessageError(in_.offset(), "the message has too many elements for its size");
      }
      for (std::size_t i = 0; i < count; ++i) read_element(field, values.emplace_back());
    }
  }

  template <typename T>
  void read_element(const FieldLayout& field, T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      value = read_number<T>(in_, field.kind);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = read_text(in_, field.kind);
    } else if constexpr (kIsTime<T>) {
      value.nanoseconds = in_.nanoseconds(std::is_same_v<T, Duration>);
    } else {
      read_struct(field.nested, value);
    }
  }

  WireReader& in_;
  const Layout& layout_;
};

/// How many fields of M a type of a definition has. Throws MessageError for a field that is there,
/// but of a kind that can't be converted.
template <typename M>
std::size_t count_known_fields(const Layout& layout, std::size_t type);

template <typename T>
[[nodiscard]] bool can_be_read(const Layout& layout, const FieldLayout& field) {
  if constexpr (std::is_arithmetic_v<T>) {
    return is_number(field.kind);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return field.kind == Kind::kString || field.kind == Kind::kWstring;
  } else if constexpr (kIsTime<T>) {
    return field.kind == kind_of<T>();
  } else {
    if (field.kind != Kind::kStruct) return false;
    (void)count_known_fields<T>(layout, field.nested);
    return true;
  }
}

template <typename M>
std::size_t count_known_fields(const Layout& layout, std::size_t type) {
  std::size_t known = 0;
  const auto check = [&]<typename T>(const FieldName& name, const T& /*value*/) {
    for (const FieldLayout& field : layout.structs[type].fields) {
      if (!DefinedReader::is_called(field, name)) continue;
      bool fits = false;
      if constexpr (kIsVector<T> || kIsArray<T>) {
        fits = field.shape != Shape::kOne && can_be_read<typename T::value_type>(layout, field);
      } else {
        fits = field.shape == Shape::kOne && can_be_read<T>(layout, field);
      }
      if (!fits) {
        throw MessageError(0, "the definition's field " + field.name + " is not what it is in " +
                                  std::string(Fields<M>::kName));
      }
      ++known;
    }
  };
  const M message{};
  Fields<M>::visit(check, message);
  return known;
}

}  // namespace loopstone
