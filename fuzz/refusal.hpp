#pragma once

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <initializer_list>
#include <string_view>

#include "loopstone/base/error.hpp"

namespace loopstone::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Whether a target goes on with what it has read: maps, matches, solves. LOOPSTONE_FUZZ_READ_ONLY
/// leaves that out, for short runs under sanitizers that are there for the readers.
inline bool goes_on() { return std::getenv("LOOPSTONE_FUZZ_READ_ONLY") == nullptr; }

/// Traps when the words of an error are no help to a user: empty, another library's (unless they
/// stand in the input, which errors quote), or a number without end.
inline void expect_own_words(const std::exception& error, std::string_view input) {
  const std::string_view words = error.what();
  const auto refuse = [&](const char* reason) {
    std::fprintf(stderr, "%s: %.*s\n", reason, static_cast<int>(words.size()), words.data());
    __builtin_trap();
  };
  if (words.empty()) refuse("an error without words");
  for (const char* foreign : {"[json.exception", "std::", "basic_string", "vector::", "yaml-cpp"}) {
    if (words.find(foreign) != words.npos && input.find(foreign) == input.npos)
      refuse("an error in another library's words");
  }
  constexpr int kMostDigits = 60;
  int digits = 0;
  for (const char c : words) {
    digits = std::isdigit(static_cast<unsigned char>(c)) != 0 ? digits + 1 : 0;
    if (digits > kMostDigits) refuse("an error with a number of more than 60 digits");
  }
}

/// Runs what a target does with its input: damage is expected to be refused in plain words, and
/// nothing worse.
/// \return what LLVMFuzzerTestOneInput must return
template <typename Body>
int expect_work_or_refusal(std::string_view input, Body&& body) {
  try {
    body();
  } catch (const DataError& error) {
    expect_own_words(error, input);
  } catch (const UsageError& error) {
    expect_own_words(error, input);
  }
  return 0;
}

}  // namespace loopstone::fuzz
