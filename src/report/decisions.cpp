#include "report/decisions.hpp"

#include <fmt/format.h>

#include <variant>

#include "formats/toml_values.hpp"

namespace loopstone {

namespace {

std::string text_of(const std::variant<bool, int, double>& value) {
  if (const auto* real = std::get_if<double>(&value)) return toml_number(*real);
  if (const auto* whole = std::get_if<int>(&value)) return fmt::format("{}", *whole);
  return std::get<bool>(value) ? "true" : "false";
}

}  // namespace

std::string format_decisions(std::span<const NumberGroup> groups) {
  std::string text = "# What the map was made and judged by beside its options, for the record.\n";
  for (const NumberGroup& group : groups) {
    text += fmt::format("\n[{}]\n", group.name);
    for (const DecisionNumber& number : group.numbers) {
      text += fmt::format("{} = {}  # {}\n", number.name, text_of(number.value), number.origin);
    }
  }
  return text;
}

}  // namespace loopstone
