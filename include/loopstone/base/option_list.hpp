#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/options.hpp"

namespace loopstone {

/// One field of an option struct: its dotted name, where its value lives, the rule it must keep and
/// its help text. The pointers lead into the struct that was listed, which must outlive the entry.
struct OptionEntry {
  std::string key;  ///< "front_end.max_range_m": groups, then the field
  std::variant<bool*, int*, double*, std::string*, WordField> value{};
  std::optional<Range> range{};  ///< of int and double
  std::string help{};
};

/// An option that could not be taken, with everything a user needs to put it right.
struct OptionProblem {
  std::string key;    ///< empty when the file as a whole can't be read
  std::string value;  ///< as it was given; empty when the key is the problem
  std::string rule;   ///< what would be right
  Location where{};   ///< file and line, or "--set"
};

/// "options.toml:3: resolution_m = 7: must be a number from 0.005 to 1"
[[nodiscard]] std::string to_string(const OptionProblem& problem);

/// Several things wrong with the options, all at once. what() has one line for each.
class OptionsError : public UsageError {
 public:
  explicit OptionsError(std::vector<OptionProblem> problems);
  [[nodiscard]] const std::vector<OptionProblem>& problems() const { return problems_; }

 private:
  std::vector<OptionProblem> problems_;
};

/// The visitor of visit_options (base/options.hpp) that lists every field of a struct and of its
/// groups.
class OptionLister {
 public:
  explicit OptionLister(std::vector<OptionEntry>& entries, std::string prefix = {})
      : entries_(&entries), prefix_(std::move(prefix)) {}

  void operator()(std::string_view name, bool& value, std::string_view help) {
    add(name, &value, {}, help);
  }
  void operator()(std::string_view name, int& value, Range range, std::string_view help) {
    add(name, &value, range, help);
  }
  void operator()(std::string_view name, double& value, Range range, std::string_view help) {
    add(name, &value, range, help);
  }
  void operator()(std::string_view name, std::string& value, std::string_view help) {
    add(name, &value, {}, help);
  }
  template <WithWords Enum>
  void operator()(std::string_view name, Enum& value, std::string_view help) {
    add(name, WordField(value), {}, help);
  }

  template <typename Options>
  void group(std::string_view name, Options& options) {
    visit_options(options, OptionLister(*entries_, prefix_ + std::string(name) + "."));
  }

 private:
  void add(std::string_view name, decltype(OptionEntry::value) value, std::optional<Range> range,
           std::string_view help);

  std::vector<OptionEntry>* entries_;
  std::string prefix_;
};

/// Every option of a struct that has visit_options, groups included, in the order in which they are
/// described.
template <typename Options>
[[nodiscard]] std::vector<OptionEntry> list_options(Options& options) {
  std::vector<OptionEntry> entries;
  visit_options(options, OptionLister(entries));
  return entries;
}

/// What the entry demands, for people: "a number from 0.005 to 1", "one of huber, cauchy", "true or
/// false".
[[nodiscard]] std::string rule_of(const OptionEntry& entry);

/// Whether the entry's value is what it demands. No number (NaN) is in no range.
[[nodiscard]] bool keeps_rule(const OptionEntry& entry);

/// What of these is not what it demands.
[[nodiscard]] std::vector<OptionProblem> problems_of(const std::vector<OptionEntry>& entries);

/// What is wrong with the values of an option struct, groups included: all of it at once, each with
/// key, value and rule. Empty when nothing is.
template <typename Options>
[[nodiscard]] std::vector<OptionProblem> problems(Options options) {
  return problems_of(list_options(options));
}

/// For the doors of the library. Throws OptionsError with all problems.
template <typename Options>
void require_valid(const Options& options) {
  std::vector<OptionProblem> found = problems(options);
  if (!found.empty()) throw OptionsError(std::move(found));
}

}  // namespace loopstone
