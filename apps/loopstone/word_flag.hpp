#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/words.hpp"

namespace CLI {
class App;
}

namespace loopstone::app {

/// A flag that takes one word of several; the help lists them, others are refused.
struct WordFlag {
  std::string flag;
  std::vector<std::string> words;
  std::string help;
  std::string default_word{};  ///< shown in the help; empty: the help text says it
};

/// \param take  is given the word that was typed
void add_word_flag(CLI::App& command, const WordFlag& flag,
                   std::function<void(const std::string&)> take);

template <WithWords Enum>
[[nodiscard]] std::vector<std::string> word_list() {
  return {kWords<Enum>.begin(), kWords<Enum>.end()};
}

/// A flag that takes the words of an enum (base/words.hpp). \param value  outlives the command
template <WithWords Enum>
void add_word_flag(CLI::App& command, const std::string& flag, Enum& value,
                   const std::string& help) {
  add_word_flag(command, {flag, word_list<Enum>(), help, std::string(to_string(value))},
                [&value](const std::string& word) { value = *find_word<Enum>(word); });
}

/// The same where the flag may be left out.
template <WithWords Enum>
void add_word_flag(CLI::App& command, const std::string& flag, std::optional<Enum>& value,
                   const std::string& help) {
  add_word_flag(command, {flag, word_list<Enum>(), help},
                [&value](const std::string& word) { value = find_word<Enum>(word); });
}

}  // namespace loopstone::app
