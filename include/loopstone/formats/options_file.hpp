#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/option_list.hpp"

namespace loopstone {

/// Writes the values of a TOML text into the options; groups are tables. Returns what could not be
/// taken (unknown keys, wrong types, values outside their range); those options keep their value,
/// the others are set.
/// \param path names the text in the problems
[[nodiscard]] std::vector<OptionProblem> apply_toml(const std::vector<OptionEntry>& options,
                                                    std::string_view toml, const std::string& path);

/// The same from a file. A file that can't be read is a problem too.
[[nodiscard]] std::vector<OptionProblem> apply_options_file(const std::vector<OptionEntry>& options,
                                                            const std::string& path);

/// Writes one "key=value" into the options. Text needs no quotes.
[[nodiscard]] std::vector<OptionProblem> apply_assignment(const std::vector<OptionEntry>& options,
                                                          std::string_view assignment);

/// The options as TOML: groups as tables, each option under its help text and its rule as a
/// comment. Read back it gives the same values to the last bit.
[[nodiscard]] std::string options_to_toml(const std::vector<OptionEntry>& options);

/// Of `known` the word that is nearest to `word` by edit distance; compares whole dotted keys and,
/// so that a forgotten group is found, last parts. Empty when nothing is near.
[[nodiscard]] std::string nearest_key(std::string_view word, const std::vector<std::string>& known);

}  // namespace loopstone
