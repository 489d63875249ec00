#include "word_flag.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

namespace loopstone::app {

void add_word_flag(CLI::App& command, const WordFlag& flag,
                   std::function<void(const std::string&)> take) {
  CLI::Option* option =
      command.add_option_function<std::string>(flag.flag, std::move(take), flag.help);
  option->type_name(fmt::format("{}", fmt::join(flag.words, "|")))
      ->check(CLI::IsMember(flag.words).description(""));
  if (!flag.default_word.empty()) option->default_str(flag.default_word);
}

}  // namespace loopstone::app
