#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// The front of a text that is a short decimal number, and where it ends.
struct ShortNumber {
  double value = 0.0;
  const char* end = nullptr;  ///< null: no number, or one that takes more care
};

/// Clinger 1990: at most 15 digits and a power of ten up to 1e15 are both exact as doubles, so that
/// one division rounds once. Range values and coordinates are such numbers.
[[nodiscard]] inline ShortNumber parse_short_number(const char* c, const char* end) {
  constexpr double kPowers[] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  constexpr std::ptrdiff_t kMostDigits = 15;
  const bool negative = c != end && *c == '-';
  if (c != end && (*c == '-' || *c == '+')) ++c;
  const auto is_digit = [](char letter) { return letter >= '0' && letter <= '9'; };
  std::uint64_t digits = 0;  // of too many digits it is of no use
  const char* const first = c;
  for (; c != end && is_digit(*c); ++c) digits = digits * 10 + static_cast<unsigned>(*c - '0');
  std::ptrdiff_t count = c - first;
  std::ptrdiff_t decimals = 0;
  if (c != end && *c == '.') {
    const char* const point = c++;
    for (; c != end && is_digit(*c); ++c) digits = digits * 10 + static_cast<unsigned>(*c - '0');
    decimals = c - point - 1;
    count += decimals;
  }
  if (count == 0 || count > kMostDigits) return {};
  const double value = static_cast<double>(digits) / kPowers[decimals];
  return {negative ? -value : value, c};
}

/// A decimal number, correctly rounded; nothing when the whole word isn't one. "nan" and "inf" are
/// numbers.
[[nodiscard]] inline std::optional<double> parse_number(std::string_view word) {
  const ShortNumber number = parse_short_number(word.data(), word.data() + word.size());
  if (number.end != nullptr && number.end == word.data() + word.size()) return number.value;
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (stop != word.data() + word.size() || word.empty()) return std::nullopt;
  // Too large for a double is infinite for every purpose here; too small is 0.
  if (error == std::errc::result_out_of_range) {
    return word.find("e-") != word.npos || word.find("E-") != word.npos
               ? 0.0
               : std::numeric_limits<double>::infinity();
  }
  if (error != std::errc{}) return std::nullopt;
  return value;
}

/// Cuts a line into words at blanks and tabs.
class Words {
 public:
  explicit Words(std::string_view text) : next_(text.data()), end_(text.data() + text.size()) {}

  /// The next word; empty at the end.
  [[nodiscard]] std::string_view next() {
    while (next_ != end_ && is_blank(*next_)) ++next_;
    const char* const first = next_;
    while (next_ != end_ && !is_blank(*next_)) ++next_;
    return {first, static_cast<std::size_t>(next_ - first)};
  }
  /// The next word if it is a short decimal number; else it stays the next one.
  [[nodiscard]] std::optional<double> next_short_number() {
    while (next_ != end_ && is_blank(*next_)) ++next_;
    const ShortNumber number = parse_short_number(next_, end_);
    if (number.end == nullptr || (number.end != end_ && !is_blank(*number.end))) return {};
    next_ = number.end;
    return number.value;
  }
  [[nodiscard]] std::string_view rest() const {
    return {next_, static_cast<std::size_t>(end_ - next_)};
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  const char* next_;
  const char* end_;
};

[[nodiscard]] inline std::optional<std::int64_t> parse_integer(std::string_view word) {
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc{} || stop != word.data() + word.size())
    return std::nullopt;
  return value;
}

/// Seconds in decimal to whole nanoseconds, digit by digit: a double would lose some of them at
/// Unix times. Digits after the ninth decimal are cut off. Nothing when it isn't a number or lies
/// beyond +-145 years.
[[nodiscard]] inline std::optional<Stamp> parse_stamp(std::string_view word) {
  constexpr std::int64_t kMostSeconds = 4'600'000'000;  // so that differences fit in 64 bits, too
  const bool negative = word.starts_with('-');
  std::size_t i = negative || word.starts_with('+') ? 1 : 0;
  std::int64_t seconds = 0;
  bool digits = false;
  for (; i < word.size() && word[i] >= '0' && word[i] <= '9'; ++i) {
    seconds = seconds * 10 + (word[i] - '0');
    digits = true;
    if (seconds > kMostSeconds) return std::nullopt;
  }
  std::int64_t nanoseconds = 0;
  if (i < word.size() && word[i] == '.') {
    std::int64_t weight = 100'000'000;
    for (++i; i < word.size() && word[i] >= '0' && word[i] <= '9'; ++i, weight /= 10) {
      nanoseconds += weight * (word[i] - '0');
      digits = true;
    }
  }
  if (digits && i == word.size()) {
    const std::int64_t total = seconds * 1'000'000'000 + nanoseconds;
    return Stamp{negative ? -total : total};
  }
  const auto value = parse_number(word);  // 1.13486e+09
  if (!value || !(std::abs(*value) < static_cast<double>(kMostSeconds))) return std::nullopt;
  return Stamp::from_seconds(*value);
}

}  // namespace loopstone
