#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/words.hpp"

namespace loopstone {

// Data as bytes: ByteWriter takes it down, ByteReader puts it back. Data names its fields once, for
// both directions, so that they can't diverge:
//
//   struct Count {
//     int number = 0;
//     std::vector<std::string> names{};
//
//     template <typename Archive>
//     void archive(Archive& a) {
//       a(number, names);
//       a.check(number >= 0, "a negative count");  // when reading: else the bytes are refused
//     }
//   };
//
// What lives and works is not data. It gives its state out as data and goes on from it:
//
//   class Counter {
//    public:
//     struct State { ... archive() ... };
//     [[nodiscard]] const State& state() const;
//     void restore(State state);  // throws when nothing can have led to it
//
// What is fixed by how an object was made (its options) and what can be computed again (caches) is
// no part of its state.
//
// Numbers are little-endian and as wide as their type; a bool is one byte, 0 or 1. Lists, sets,
// maps and text begin with their count in 64 bits, optional values with a bool. Matrices go column
// by column. Enums count from 0 and have a table of words (base/words.hpp), or say beside their
// definition which of their values is the last:
//
//   enum class Colour { kRed, kGreen };
//   constexpr Colour last_of(Colour) { return Colour::kGreen; }

/// The largest value of an enum.
template <typename Enum>
[[nodiscard]] constexpr Enum last_enumerator() {
  if constexpr (WithWords<Enum>) {
    return static_cast<Enum>(kWordTable<Enum>.size() - 1);
  } else {
    return last_of(Enum{});
  }
}

/// Whether runs of these can be copied as they are.
template <typename T>
inline constexpr bool kPlainBytes = std::is_arithmetic_v<T> && !std::is_same_v<T, bool> &&
                                    (std::endian::native == std::endian::little || sizeof(T) == 1);

/// Takes state down. Cost: about that of copying it.
class ByteWriter {
 public:
  static constexpr bool kReads = false;

  template <typename... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }
  void check(bool /*holds*/, const char* /*what*/) {}
  /// Elements without default constructor.
  template <typename T, typename Make>
  void list(const std::vector<T>& values, Make&& /*make*/) {
    put(values);
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  template <typename T>
  void put(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      bytes_.push_back(value ? '\1' : '\0');
    } else if constexpr (std::is_enum_v<T>) {
      put(static_cast<std::underlying_type_t<T>>(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
      if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(bytes);
      bytes_.append(bytes.data(), bytes.size());
    } else {
      // One field list serves both directions, so it can't be const; nothing is written to while
      // saving.
      const_cast<T&>(value).archive(*this);
    }
  }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_.append(text);
  }
  template <typename T, int kRows, int kColumns>
  void put(const Eigen::Matrix<T, kRows, kColumns>& matrix) {
    static_assert(kRows > 0 && kColumns > 0, "of fixed size only");
    for (int i = 0; i < kRows * kColumns; ++i) put(matrix.data()[i]);
  }
  template <typename T, std::size_t kCount>
  void put(const std::array<T, kCount>& values) {
    for (const T& value : values) put(value);
  }
  template <typename A, typename B>
  void put(const std::pair<A, B>& values) {
    put(values.first);
    put(values.second);
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    if constexpr (kPlainBytes<T>) {
      put(static_cast<std::uint64_t>(values.size()));
      if (!values.empty()) {
        const auto begin = bytes_.size();
        bytes_.resize(begin + values.size() * sizeof(T));
        std::memcpy(bytes_.data() + begin, values.data(), values.size() * sizeof(T));
      }
    } else {
      put_each(values);
    }
  }
  template <typename T>
  void put(const std::deque<T>& values) {
    put_each(values);
  }
  template <typename Key, typename T>
  void put(const std::map<Key, T>& values) {
    put_each(values);
  }
  template <typename T>
  void put(const std::set<T>& values) {
    put_each(values);
  }
  template <typename Values>
  void put_each(const Values& values) {
    put(static_cast<std::uint64_t>(values.size()));
    for (const auto& value : values) put(value);
  }

  std::string bytes_{};
};

/// Puts state back. No length is trusted: no more is ever set up than there are bytes left to fill
/// it from.
/// Throws DataError with the offset at which the bytes end too early or say what cannot be.
class ByteReader {
 public:
  static constexpr bool kReads = true;

  /// \param bytes   must outlive the reader
  /// \param origin  path, and offset of the first byte, for errors
  explicit ByteReader(std::string_view bytes, Location origin = {})
      : bytes_(bytes), origin_(std::move(origin)) {}

  template <typename... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }
  /// Refuses the bytes unless the condition holds.
  void check(bool holds, const char* what) const {
    if (!holds) fail(what);
  }
  template <typename T, typename Make>
  void list(std::vector<T>& values, Make&& make) {
    values.clear();
    for (std::uint64_t count = get_count(1); count > 0; --count) {
      values.push_back(make());
      get(values.back());
    }
  }

  /// Refuses bytes that are left over.
  void end() const { check(at_ == bytes_.size(), "bytes are left over"); }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    Location location = origin_;
    location.byte_offset = origin_.byte_offset.value_or(0) + static_cast<std::int64_t>(at_);
    throw DataError(location, "damaged: " + what);
  }
  const char* next(std::uint64_t count) {
    if (count > bytes_.size() - at_) fail("ends too early");
    const char* const bytes = bytes_.data() + at_;
    at_ += static_cast<std::size_t>(count);
    return bytes;
  }
  /// \param least_bytes  of one element
  [[nodiscard]] std::uint64_t get_count(std::size_t least_bytes) {
    std::uint64_t count = 0;
    get(count);
    if (count > (bytes_.size() - at_) / least_bytes) fail("a list longer than what is left");
    return count;
  }

  template <typename T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      const char byte = *next(1);
      if (byte != '\0' && byte != '\1') fail("neither yes nor no");
      value = byte == '\1';
    } else if constexpr (std::is_enum_v<T>) {
      std::underlying_type_t<T> number{};
      get(number);
      using Bits = std::make_unsigned_t<std::underlying_type_t<T>>;  // what is negative is large
      if (static_cast<Bits>(number) > static_cast<Bits>(last_enumerator<T>()))
        fail("a kind that is none");
      value = static_cast<T>(number);
    } else if constexpr (std::is_arithmetic_v<T>) {
      std::array<char, sizeof(T)> bytes;
      std::memcpy(bytes.data(), next(sizeof(T)), sizeof(T));
      if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(bytes);
      value = std::bit_cast<T>(bytes);
    } else {
      value.archive(*this);
    }
  }
  void get(std::string& text) {
    const std::uint64_t count = get_count(1);
    text.assign(next(count), static_cast<std::size_t>(count));
  }
  template <typename T, int kRows, int kColumns>
  void get(Eigen::Matrix<T, kRows, kColumns>& matrix) {
    static_assert(kRows > 0 && kColumns > 0, "of fixed size only");
    for (int i = 0; i < kRows * kColumns; ++i) get(matrix.data()[i]);
  }
  template <typename T, std::size_t kCount>
  void get(std::array<T, kCount>& values) {
    for (T& value : values) get(value);
  }
  template <typename A, typename B>
  void get(std::pair<A, B>& values) {
    get(values.first);
    get(values.second);
  }
  template <typename T>
  void get(std::optional<T>& value) {
    bool has_value = false;
    get(has_value);
    value.reset();
    if (has_value) get(value.emplace());
  }
  template <typename T>
  void get(std::vector<T>& values) {
    if constexpr (kPlainBytes<T>) {
      values.resize(static_cast<std::size_t>(get_count(sizeof(T))));
      const std::size_t size = values.size() * sizeof(T);
      if (size > 0) std::memcpy(values.data(), next(size), size);
    } else {
      get_each(values);
    }
  }
  void get(std::vector<bool>& values) {
    values.clear();
    for (std::uint64_t count = get_count(1); count > 0; --count) {
      bool value = false;
      get(value);
      values.push_back(value);
    }
  }
  template <typename T>
  void get(std::deque<T>& values) {
    get_each(values);
  }
  template <typename Values>
  void get_each(Values& values) {
    values.clear();
    for (std::uint64_t count = get_count(1); count > 0; --count) get(values.emplace_back());
  }
  template <typename Key, typename T>
  void get(std::map<Key, T>& values) {
    values.clear();
    for (std::uint64_t count = get_count(1); count > 0; --count) {
      std::pair<Key, T> value;
      get(value);
      check(values.insert(std::move(value)).second, "a key twice");
    }
  }
  template <typename T>
  void get(std::set<T>& values) {
    values.clear();
    for (std::uint64_t count = get_count(1); count > 0; --count) {
      T value{};
      get(value);
      check(values.insert(std::move(value)).second, "a value twice");
    }
  }

  std::string_view bytes_;
  Location origin_;
  std::size_t at_ = 0;
};

}  // namespace loopstone
