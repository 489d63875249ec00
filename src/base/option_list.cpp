#include "loopstone/base/option_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "loopstone/base/short_text.hpp"

namespace loopstone {

namespace {

/// So many problems are told one by one; who has more has another file in hand than he thinks.
constexpr std::size_t kTold = 20;

std::string message_of(const std::vector<OptionProblem>& problems) {
  if (problems.size() == 1) return to_string(problems.front());
  std::string text = fmt::format("{} problems with the options:", problems.size());
  for (const OptionProblem& problem : std::span(problems).first(std::min(kTold, problems.size())))
    text += "\n  " + to_string(problem);
  if (problems.size() > kTold) text += fmt::format("\n  and {} more", problems.size() - kTold);
  return text;
}

std::string value_of(const OptionEntry& entry) {
  return std::visit([](const auto& value) { return fmt::format("{}", *value); }, entry.value);
}

}  // namespace

std::string to_string(const OptionProblem& problem) {
  std::string text = to_string(problem.where) + ": ";
  if (!problem.key.empty()) text += problem.key;
  if (!problem.value.empty()) text += " = " + problem.value;
  if (!problem.key.empty()) text += ": ";
  return with_short_numbers(text + problem.rule);
}

OptionsError::OptionsError(std::vector<OptionProblem> problems)
    : UsageError(message_of(problems)), problems_(std::move(problems)) {}

void OptionLister::add(std::string_view name, decltype(OptionEntry::value) value,
                       std::optional<Range> range, std::string_view help) {
  entries_->push_back({prefix_ + std::string(name), value, range, std::string(help)});
}

std::string rule_of(const OptionEntry& entry) {
  if (std::holds_alternative<bool*>(entry.value)) return "true or false";
  if (std::holds_alternative<std::string*>(entry.value)) return "a text";
  if (const auto* choice = std::get_if<WordField>(&entry.value)) {
    return fmt::format("one of {}", fmt::join(choice->words(), ", "));
  }
  const bool whole = std::holds_alternative<int*>(entry.value);
  const std::string_view kind = whole ? "a whole number" : "a number";
  if (!entry.range) return std::string(kind);
  return fmt::format("{} from {} to {}", kind, entry.range->lowest, entry.range->highest);
}

bool keeps_rule(const OptionEntry& entry) {
  const auto in_range = [&](double value) {
    return !entry.range || (value >= entry.range->lowest && value <= entry.range->highest);
  };
  if (const auto* const* number = std::get_if<int*>(&entry.value)) return in_range(**number);
  if (const auto* const* number = std::get_if<double*>(&entry.value)) return in_range(**number);
  const auto* choice = std::get_if<WordField>(&entry.value);
  return choice == nullptr || std::ranges::find(choice->words(), **choice) != choice->words().end();
}

std::vector<OptionProblem> problems_of(const std::vector<OptionEntry>& entries) {
  std::vector<OptionProblem> problems;
  for (const OptionEntry& entry : entries) {
    if (keeps_rule(entry)) continue;
    problems.push_back(
        {entry.key, value_of(entry), "must be " + rule_of(entry), {"options", {}, {}}});
  }
  return problems;
}

}  // namespace loopstone
