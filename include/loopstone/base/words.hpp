#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

namespace loopstone {

// The words of an enum, once, beside the enum:
//
//   enum class OdometryUse { kCheck, kTrust, kIgnore };
//
//   constexpr auto words_of(OdometryUse /*any*/) {
//     using enum OdometryUse;
//     return std::array{Word{kCheck, "check"}, Word{kTrust, "trust"}, Word{kIgnore, "ignore"}};
//   }
//
// Options, flags, files and reports all go through this table, in its order.

/// An enumerator and how it is called in files, on the command line and in reports.
template <typename Enum>
struct Word {
  Enum value;
  std::string_view word;
};
template <typename Enum>
Word(Enum, std::string_view) -> Word<Enum>;

/// An enum with a table of words.
template <typename Enum>
concept WithWords = std::is_enum_v<Enum> && requires(Enum any) {
  words_of(any);
};

/// Whether a value is one of its enum's enumerators: the compiler writes others as "(Enum)7".
template <auto kValue>
[[nodiscard]] constexpr bool is_enumerator() {
  constexpr std::string_view kWritten = __PRETTY_FUNCTION__;
  for (std::size_t i = kWritten.find("kValue = "); i + 1 < kWritten.size(); ++i) {
    const char next = kWritten[i + 1];
    if (kWritten[i] == ')' && next >= '0' && next <= '9') return false;
  }
  return true;
}

/// Whether every enumerator has one word. Enumerators count from 0.
template <WithWords Enum>
[[nodiscard]] constexpr bool has_all_words() {
  constexpr auto kTable = words_of(Enum{});
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    const auto is_it = [i](const Word<Enum>& known) { return known.value == static_cast<Enum>(i); };
    if (std::ranges::count_if(kTable, is_it) != 1) return false;
  }
  return !is_enumerator<static_cast<Enum>(kTable.size())>();
}

/// The table; not made anew with every question.
template <WithWords Enum>
inline constexpr auto kWordTable = [] {
  static_assert(has_all_words<Enum>(), "words_of() must have one word for every enumerator");
  return words_of(Enum{});
}();

/// The words alone.
template <WithWords Enum>
inline constexpr auto kWords = [] {
  std::array<std::string_view, kWordTable<Enum>.size()> words{};
  std::ranges::transform(kWordTable<Enum>, words.begin(), &Word<Enum>::word);
  return words;
}();

/// "unknown" for a value that is no enumerator.
template <WithWords Enum>
[[nodiscard]] constexpr std::string_view to_string(Enum value) {
  for (const Word<Enum>& known : kWordTable<Enum>) {
    if (known.value == value) return known.word;
  }
  return "unknown";
}

/// Nothing for a word that is none of the enum's.
template <WithWords Enum>
[[nodiscard]] constexpr std::optional<Enum> find_word(std::string_view word) {
  for (const Word<Enum>& known : kWordTable<Enum>) {
    if (known.word == word) return known.value;
  }
  return std::nullopt;
}

/// A pointer to an enum field of any type, which reads as its word: what lists of options hold. The
/// field must outlive it.
class WordField {
 public:
  template <WithWords Enum>
  explicit WordField(Enum& field)
      : field_(&field),
        words_(kWords<Enum>),
        word_([](const void* at) { return to_string(*static_cast<const Enum*>(at)); }),
        set_([](void* at, std::size_t place) {
          *static_cast<Enum*>(at) = kWordTable<Enum>[place].value;
        }) {}

  /// All that it may be.
  [[nodiscard]] std::span<const std::string_view> words() const { return words_; }
  /// What it is; "unknown" for no enumerator.
  [[nodiscard]] std::string_view operator*() const { return word_(field_); }
  /// False for a word that is none of its own; the field then stays.
  [[nodiscard]] bool set(std::string_view word) const;

 private:
  void* field_;
  std::span<const std::string_view> words_;
  std::string_view (*word_)(const void*);
  void (*set_)(void*, std::size_t place);
};

}  // namespace loopstone
