#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

#include "loopstone/base/rng.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "messages/all_messages.hpp"
#include "messages/wire_values.hpp"

// Messages of all types with something in every field, and their comparison without their bytes.
namespace loopstone::test {

/// Calls f.template operator()<M>() for every message M.
template <typename F>
void for_each_message(const F& f) {
#define LOOPSTONE_CALL(M) f.template operator()<msg::M>();
  LOOPSTONE_ALL_MESSAGES(LOOPSTONE_CALL)
#undef LOOPSTONE_CALL
}

/// Visits all values that messages keep; calls one(value) for those that are no struct or list, and
/// size() for the length of a sequence.
template <typename Derived>
struct EveryValue {
  template <typename T>
  void operator()(const FieldName& field, T& value) {
    if (!field.ros1.empty() && !field.ros2.empty()) fill(value);
  }
  template <typename T>
  void fill(T& value) {
    using Plain = std::remove_const_t<T>;
    if constexpr (std::is_arithmetic_v<Plain> || std::is_same_v<Plain, std::string> ||
                  kIsTime<Plain>) {
      self().one(value);
    } else if constexpr (kIsVector<Plain>) {
      self().size(value);
      for (auto& element : value) fill(element);
    } else if constexpr (kIsArray<Plain>) {
      for (auto& element : value) fill(element);
    } else {
      Fields<Plain>::visit(*this, value);
    }
  }
  Derived& self() { return static_cast<Derived&>(*this); }
};

/// As known_messages.hpp describes it.
struct CountedValues : EveryValue<CountedValues> {
  int count = 0;

  template <typename T>
  void one(T& value) {
    ++count;
    if constexpr (std::is_same_v<T, bool>) {
      value = count % 2 == 1;
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = "s" + std::to_string(count);
    } else if constexpr (kIsTime<T>) {
      value.nanoseconds = std::int64_t{count} * 1'000'000'001;
    } else {
      value = static_cast<T>(sizeof(T) == 1 ? count % 100 : count);
    }
  }
  template <typename E>
  void size(std::vector<E>& values) {
    values.resize(3);
  }
};

/// Values of any size; sequences of up to 5 elements.
struct RandomValues : EveryValue<RandomValues> {
  explicit RandomValues(std::uint64_t seed) : rng(seed) {}
  Rng rng;

  template <typename T>
  void one(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = rng.below(2) == 1;
    } else if constexpr (std::is_same_v<T, std::string>) {
      value.clear();
      for (std::uint64_t left = rng.below(9); left > 0; --left) {
        value += static_cast<char>('a' + rng.below(26));
      }
    } else if constexpr (std::is_same_v<T, Stamp>) {
      value.nanoseconds = static_cast<std::int64_t>(rng.below(0x7fffffff'00000000) % kMostTime);
    } else if constexpr (std::is_same_v<T, Duration>) {
      value.nanoseconds = static_cast<std::int64_t>(rng.below(2 * kMostTime)) - kMostTime;
    } else if constexpr (std::is_floating_point_v<T>) {
      value = rng.below(8) == 0 ? std::numeric_limits<T>::quiet_NaN()
                                : static_cast<T>(rng.normal(0.0, 1e6));
    } else {
      value = static_cast<T>(rng());
    }
  }
  template <typename E>
  void size(std::vector<E>& values) {
    values.resize(rng.below(6));
  }

 private:
  static constexpr std::int64_t kMostTime = std::int64_t{0x7fffffff} * 1'000'000'000;
};

/// All values in a row, NaN like any other.
struct FlatValues : EveryValue<FlatValues> {
  std::string flat{};

  template <typename T>
  void one(const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      flat += value + "|";
    } else if constexpr (kIsTime<T>) {
      flat += std::to_string(value.nanoseconds) + "|";
    } else if constexpr (std::is_same_v<T, float>) {
      flat += std::to_string(std::bit_cast<std::uint32_t>(value)) + "|";
    } else if constexpr (std::is_same_v<T, double>) {
      flat += std::to_string(std::bit_cast<std::uint64_t>(value)) + "|";
    } else {
      flat += std::to_string(value) + "|";
    }
  }
  template <typename E>
  void size(const std::vector<E>& values) {
    flat += "#" + std::to_string(values.size()) + "|";
  }
};

template <typename M>
[[nodiscard]] M counted_message() {
  M message;
  CountedValues().fill(message);
  return message;
}
template <typename M>
[[nodiscard]] M random_message(std::uint64_t seed) {
  M message;
  RandomValues(seed).fill(message);
  return message;
}
template <typename M>
[[nodiscard]] std::string flat(const M& message) {
  FlatValues values;
  values.fill(message);
  return values.flat;
}

template <typename M>
[[nodiscard]] std::string encoded(WireFormat format, const M& message) {
  std::string bytes;
  encode_message(format, message, bytes);
  return bytes;
}
template <typename M>
[[nodiscard]] std::string big_endian_cdr(const M& message) {
  std::string bytes;
  WireWriter out(WireFormat::kCdr, bytes, std::endian::big);
  const FieldWriter writer{out};
  writer.write(message);
  return bytes;
}

template <typename M>
[[nodiscard]] M decoded(WireFormat format, std::string_view bytes,
                        const MessageDefinition& definition = {}) {
  M message;
  MessageDecoder<M>(format, definition).decode(bytes, message);
  return message;
}

[[nodiscard]] inline std::string hexadecimal(std::string_view bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    text += kDigits[static_cast<unsigned char>(c) >> 4];
    text += kDigits[static_cast<unsigned char>(c) & 15];
  }
  return text;
}

}  // namespace loopstone::test
