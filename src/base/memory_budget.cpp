#include "loopstone/base/memory_budget.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

#include "loopstone/base/number_text.hpp"

namespace loopstone {

namespace {

constexpr std::string_view kPrefixes = "KMGTPE";

/// The least --max-memory that allows so much, rounded up to two digits: "7.3G".
std::string flag_for(std::uint64_t bytes) {
  constexpr double kMega = 1048576.0;
  constexpr double kGiga = 1073741824.0;
  const auto value = static_cast<double>(bytes);
  const bool giga = value >= kGiga;
  const double rounded = std::ceil(value / (giga ? kGiga : kMega) * 10.0) / 10.0;
  return "--max-memory " + number_text(rounded, 12) + (giga ? "G" : "M");
}

}  // namespace

std::uint64_t MemoryBudget::allowed_bytes(std::uint64_t file_bytes, Growth growth) const {
  if (!by_file_size) return ceiling_bytes;
  const std::uint64_t grown = saturated_product(file_bytes, static_cast<std::uint64_t>(growth));
  return std::min(ceiling_bytes, std::max(grown, grown + kSmall));
}

void MemoryBudget::require(std::uint64_t needed_bytes, std::uint64_t file_bytes, Growth growth,
                           const Location& where) const {
  const std::uint64_t allowed = allowed_bytes(file_bytes, growth);
  if (needed_bytes <= allowed) return;
  const std::string needs = "what it holds would take " + bytes_text(needed_bytes) + " of memory";
  const bool above_ceiling = needed_bytes > ceiling_bytes;
  throw DataError(
      where, needs +
                 (above_ceiling ? "; the limit is " + bytes_text(ceiling_bytes) + "."
                                : ", which is too much for a file of " + bytes_text(file_bytes) +
                                      ": is it what it should be?") +
                 (needed_bytes > (std::uint64_t{1} << 46)
                      ? ""
                      : " To read it all the same: " + flag_for(needed_bytes)));
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::array<const char*, 7> kUnits{"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
  auto value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000.0;
  // Two digits: 1.5 MB, 34 kB.
  const double shown =
      value < 9.95 && unit > 0 ? std::round(value * 10.0) / 10.0 : std::round(value);
  return number_text(shown) + " " + kUnits[unit];
}

std::uint64_t parse_bytes(std::string_view text) {
  const auto wrong = [text] {
    return UsageError("'" + std::string(text.substr(0, 40)) +
                      "' is no amount of memory; write 512M or 2G, at least 16M");
  };
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) throw wrong();
  std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (!unit.empty()) {
    const char letter =
        unit.front() >= 'a' ? static_cast<char>(unit.front() - 'a' + 'A') : unit.front();
    const std::size_t power = kPrefixes.find(letter);
    if (power != kPrefixes.npos) {
      value = std::ldexp(value, 10 * (static_cast<int>(power) + 1));
      unit.remove_prefix(1);
    }
    if (power != kPrefixes.npos && unit.starts_with('i')) unit.remove_prefix(1);
    if (!unit.empty() && unit != "B" && unit != "b") throw wrong();
  }
  // Written so that NaN is wrong.
  if (!(value >= 16777216.0 && value < 9e18)) throw wrong();
  return static_cast<std::uint64_t>(value);
}

}  // namespace loopstone
