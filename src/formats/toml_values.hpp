#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "loopstone/formats/options_file.hpp"

namespace loopstone {

/// A leaf of a TOML document: its dotted key, where it stands and what it holds.
struct TomlValue {
  std::string key;  ///< arrays of tables are numbered: "lidars[0].x_m"
  std::int64_t line = 0;
  std::string text;  ///< the value as people write it
  /// monostate: a date, an array or whatever else no option can hold.
  std::variant<std::monostate, bool, std::int64_t, double, std::string> value{};
  /// Of an array of numbers, one row; of an array of such arrays, their rows. Nothing of others.
  std::optional<std::vector<std::vector<double>>> rows{};
};

/// A TOML document as a list of leaves in the order of the file, or the reason why it is none.
struct TomlDocument {
  std::vector<TomlValue> values{};
  std::map<std::string, std::size_t> table_arrays{};  ///< how many tables each array of tables has
  std::map<std::string, std::int64_t> table_lines{};  ///< where each of them begins: "lidars[0]"
  std::vector<OptionProblem> problems{};
};

/// Options are short: what is longer is something else.
inline constexpr std::size_t kMostOptionBytes = std::size_t{1} << 20;

/// What is longer than kMostOptionBytes, or too deep within itself for the stack, is refused before
/// it is parsed.
[[nodiscard]] TomlDocument parse_toml(std::string_view toml, const std::string& path);

/// Sets the options that the values name; returns what could not be taken.
[[nodiscard]] std::vector<OptionProblem> apply_values(const std::vector<OptionEntry>& options,
                                                      const std::vector<TomlValue>& values,
                                                      const std::string& path);

/// A number, a text and a truth as TOML writes them; the number to the last bit.
[[nodiscard]] std::string toml_number(double value);
[[nodiscard]] std::string toml_string(std::string_view text);
[[nodiscard]] std::string toml_value(const OptionEntry& entry);

}  // namespace loopstone
