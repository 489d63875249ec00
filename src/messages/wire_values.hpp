#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "messages/message_fields.hpp"
#include "messages/wire.hpp"

// Messages as they are compiled in, to and from bytes, field by field.

namespace loopstone {

template <typename T>
inline constexpr bool kIsVector = false;
template <typename T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <typename T>
inline constexpr bool kIsArray = false;
template <typename T, std::size_t kCount>
inline constexpr bool kIsArray<std::array<T, kCount>> = true;
template <typename T>
inline constexpr bool kIsTime = std::is_same_v<T, Stamp> || std::is_same_v<T, Duration>;

[[nodiscard]] constexpr std::string_view name_in(const FieldName& field, WireFormat format) {
  return format == WireFormat::kRos1 ? field.ros1 : field.ros2;
}

struct FieldReader {
  WireReader& in;

  template <typename T>
  void operator()(const FieldName& field, T& value) const {
    if (!name_in(field, in.format()).empty()) read(value);
  }

  template <typename T>
  void read(T& value) const {
    if constexpr (std::is_arithmetic_v<T>) {
      value = in.number<T>();
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = in.text();
    } else if constexpr (kIsTime<T>) {
      value.nanoseconds = in.nanoseconds(std::is_same_v<T, Duration>);
    } else if constexpr (kIsVector<T>) {
      read_vector(value);
    } else if constexpr (kIsArray<T>) {
      in.numbers(std::span<typename T::value_type>(value));
    } else {
      Fields<T>::visit(*this, value);
    }
  }

 private:
  template <typename E>
  void read_vector(std::vector<E>& values) const {
    if constexpr (std::is_arithmetic_v<E>) {
      values.resize(in.count(sizeof(E)));
      in.numbers(std::span(values));
    } else {
      // Elements are made as their bytes are there, whatever the count says.
      const std::size_t size = in.count(1);
      if (values.size() > size) values.resize(size);
      for (std::size_t i = 0; i < size; ++i) {
        if (i == values.size()) values.emplace_back();
        read(values[i]);
      }
    }
  }
};

struct FieldWriter {
  WireWriter& out;

  template <typename T>
  void operator()(const FieldName& field, const T& value) const {
    if (!name_in(field, out.format()).empty()) write(value);
  }

  template <typename T>
  void write(const T& value) const {
    if constexpr (std::is_arithmetic_v<T>) {
      out.number(value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      out.text(value);
    } else if constexpr (kIsTime<T>) {
      out.nanoseconds(value.nanoseconds, std::is_same_v<T, Duration>);
    } else if constexpr (kIsVector<T>) {
      out.count(value.size());
      write_elements(value);
    } else if constexpr (kIsArray<T>) {
      write_elements(value);
    } else {
      Fields<T>::visit(*this, value);
    }
  }

 private:
  template <typename Values>
  void write_elements(const Values& values) const {
    using E = typename Values::value_type;
    if constexpr (std::is_arithmetic_v<E>) {
      out.numbers(std::span<const E>(values));
    } else {
      for (const E& value : values) write(value);
    }
  }
};

}  // namespace loopstone
