#include "loopstone/formats/decimal_stamp.hpp"

#include <charconv>
#include <limits>

namespace loopstone {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The exponent after 'e' or 'E'; nothing when malformed. Beyond four digits it is out of any range
/// anyway.
std::optional<int> parse_exponent(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.empty() || text.size() > 5) return std::nullopt;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<Stamp> parse_decimal_stamp(std::string_view text) {
  bool negative = false;
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  int exponent = 0;
  if (const auto e = text.find_first_of("eE"); e != std::string_view::npos) {
    const auto parsed = parse_exponent(text.substr(e + 1));
    if (!parsed) return std::nullopt;
    exponent = *parsed;
    text = text.substr(0, e);
  }
  const auto point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  const std::string_view fraction =
      point == std::string_view::npos ? std::string_view{} : text.substr(point + 1);
  if (whole.empty() && fraction.empty()) return std::nullopt;

  // Digit k (from the left) counts 10^(places - 1 - k) nanoseconds.
  const int places = static_cast<int>(whole.size()) + exponent + 9;
  const int digits = static_cast<int>(whole.size() + fraction.size());
  constexpr std::uint64_t kMost =
      static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  std::uint64_t nanoseconds = 0;
  bool round_up = false;
  for (int k = 0; k < digits; ++k) {
    const auto position = static_cast<std::size_t>(k);
    const char c = position < whole.size() ? whole[position] : fraction[position - whole.size()];
    if (!is_digit(c)) return std::nullopt;
    if (k == places) round_up = c >= '5';
    if (k >= places) continue;
    if (nanoseconds > (kMost - 9) / 10) return std::nullopt;
    nanoseconds = nanoseconds * 10 + static_cast<std::uint64_t>(c - '0');
  }
  for (int k = digits; k < places && nanoseconds != 0; ++k) {
    if (nanoseconds > kMost / 10) return std::nullopt;
    nanoseconds *= 10;
  }
  nanoseconds += round_up ? 1 : 0;
  if (nanoseconds > kMost) return std::nullopt;
  const auto value = static_cast<std::int64_t>(nanoseconds);
  return Stamp{negative ? -value : value};
}

std::string format_decimal_stamp(Stamp stamp) {
  const bool negative = stamp.nanoseconds < 0;
  const auto bits = static_cast<std::uint64_t>(stamp.nanoseconds);
  const std::uint64_t magnitude = negative ? std::uint64_t{0} - bits : bits;
  const std::string fraction = std::to_string(magnitude % 1'000'000'000);
  return (negative ? "-" : "") + std::to_string(magnitude / 1'000'000'000) + "." +
         std::string(9 - fraction.size(), '0') + fraction;
}

}  // namespace loopstone
