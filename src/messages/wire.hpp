#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "loopstone/messages/message_codec.hpp"

// Numbers, strings and counts in the bytes of either serialisation. CDR: OMG's DDS-XTypes 1.3, 7.4,
// version 1; numbers are aligned to their size, at most 8 bytes, counted behind the encapsulation.

namespace loopstone {

template <typename T>
[[nodiscard]] T with_bytes_swapped(T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

class WireReader {
 public:
  /// Begins behind CDR's encapsulation. Throws MessageError when that is none that can be read.
  WireReader(WireFormat format, std::span<const char> bytes);

  [[nodiscard]] WireFormat format() const { return format_; }
  [[nodiscard]] std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  /// Of the whole message.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
  [[nodiscard]] std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

  template <typename T>
  [[nodiscard]] T number() {
    if constexpr (std::is_same_v<T, bool>) {
      return number<std::uint8_t>() != 0;
    } else {
      require(1, sizeof(T));
      T value{};
      std::memcpy(&value, at_, sizeof(T));
      at_ += sizeof(T);
      return swapped_ ? with_bytes_swapped(value) : value;
    }
  }
  /// So many as `values` holds.
  template <typename T>
  void numbers(std::span<T> values) {
    if (values.empty()) return;
    require(values.size(), sizeof(T));
    std::memcpy(values.data(), at_, values.size_bytes());
    at_ += values.size_bytes();
    if (!swapped_ || sizeof(T) == 1) return;
    for (T& value : values) value = with_bytes_swapped(value);
  }
  /// The length of a sequence whose elements have at least so many bytes each.
  [[nodiscard]] std::size_t count(std::size_t least_bytes);
  [[nodiscard]] std::string_view text();
  /// UTF-16 as UTF-8.
  [[nodiscard]] std::string wide_text();
  /// Seconds and nanoseconds: a stamp or, with `is_signed`, a duration of ROS 1.
  [[nodiscard]] std::int64_t nanoseconds(bool is_duration);
  void skip(std::size_t count, std::size_t size);
  /// What may stand behind a message: padding of CDR.
  void expect_end() const;

 private:
  /// Aligns, and makes sure that so many numbers of this size are there.
  void require(std::size_t count, std::size_t size) {
    if (format_ == WireFormat::kCdr) {
      const std::size_t pad = -static_cast<std::size_t>(at_ - origin_) & (size - 1);
      if (pad > remaining()) fail_short(pad);
      at_ += pad;
    }
    if (count > remaining() / size) fail_short(size);
  }
  [[noreturn]] void fail_short(std::size_t size) const;

  WireFormat format_;
  bool swapped_ = false;
  const char* begin_;
  const char* at_;
  const char* end_;
  const char* origin_;  ///< from which alignment counts
};

class WireWriter {
 public:
  /// \param bytes  replaced; written to until the writer's end
  WireWriter(WireFormat format, std::string& bytes, std::endian order = std::endian::little);

  [[nodiscard]] WireFormat format() const { return format_; }

  template <typename T>
  void number(T value) {
    numbers(std::span<const T>(&value, 1));
  }
  template <typename T>
  void numbers(std::span<const T> values) {
    if (values.empty()) return;
    if (format_ == WireFormat::kCdr) align(sizeof(T));
    const std::size_t begin = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    if (!swapped_ || sizeof(T) == 1) return;
    for (std::size_t at = begin; at < bytes_.size(); at += sizeof(T)) {
      std::reverse(bytes_.data() + at, bytes_.data() + at + sizeof(T));
    }
  }
  /// Throws MessageError for more than 32 bits.
  void count(std::size_t elements);
  void text(std::string_view value);
  /// Throws MessageError for seconds beyond 32 bits.
  void nanoseconds(std::int64_t value, bool is_duration);

 private:
  void align(std::size_t size) {
    constexpr std::size_t kEncapsulation = 4;
    bytes_.append((kEncapsulation - bytes_.size()) & (size - 1), '\0');
  }

  WireFormat format_;
  bool swapped_;
  std::string& bytes_;
};

}  // namespace loopstone
