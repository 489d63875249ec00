#include "result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <variant>

#include "loopstone/base/error.hpp"
#include "terminal_text.hpp"

namespace loopstone::app {

namespace {

void list_figures(const nlohmann::ordered_json& value, const std::string& prefix,
                  std::vector<SummaryFigure>& figures) {
  for (const auto& [name, child] : value.items()) {
    const std::string key = prefix + name;
    if (child.is_object()) list_figures(child, key + ".", figures);
    if (child.is_null()) figures.push_back({.key = key});
    if (!child.is_number()) continue;
    const auto number = child.get<double>();
    figures.push_back({key, std::isfinite(number) ? std::optional(number) : std::nullopt});
  }
}

}  // namespace

Result& Result::add_json(std::string_view key, nlohmann::ordered_json value) {
  nlohmann::ordered_json* place = &json_;
  for (auto dot = key.find('.'); dot != std::string_view::npos; dot = key.find('.')) {
    place = &(*place)[std::string(key.substr(0, dot))];
    key.remove_prefix(dot + 1);
  }
  (*place)[std::string(key)] = std::move(value);
  return *this;
}

Result& Result::add_row(std::string_view label, std::string text, std::string_view unit) {
  rows_.push_back({std::string(label), std::move(text), std::string(unit)});
  return *this;
}

Result& Result::add(std::string_view key, std::string_view label, double value,
                    std::string_view unit, int digits) {
  add_json(key, std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json());
  return add_row(label, std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "none",
                 std::isfinite(value) ? unit : "");
}

Result& Result::add(std::string_view key, std::string_view label, std::int64_t value,
                    std::string_view unit) {
  add_json(key, value);
  return add_row(label, fmt::format("{}", value), unit);
}

Result& Result::add(std::string_view key, std::string_view label, bool value) {
  add_json(key, value);
  return add_row(label, value ? "yes" : "no");
}

Result& Result::add(std::string_view key, std::string_view label, const std::string& value) {
  add_json(key, value);
  return add_row(label, value);
}

std::vector<SummaryFigure> Result::figures() const {
  std::vector<SummaryFigure> figures;
  list_figures(json_, "", figures);
  return figures;
}

std::string Result::table() const {
  std::size_t width = 0;
  for (const Row& row : rows_) width = std::max(width, row.label.size());
  std::string text;
  for (const Row& row : rows_) {
    if (!row.label.empty()) text += fmt::format("{:<{}}  ", row.label, width);
    text += row.text;
    if (!row.unit.empty()) text += " " + row.unit;
    text += '\n';
  }
  return text;
}

void Result::print(const AppContext& context) const {
  // Text that is not UTF-8 (a file name) must not end the program.
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  print_to_stdout(context.json() ? json_.dump(2, ' ', false, kReplace) + "\n"
                                 : terminal_text(table()));
}

nlohmann::ordered_json numbers_json(std::span<const NumberGroup> groups) {
  auto numbers = nlohmann::ordered_json::object();
  for (const NumberGroup& group : groups)
    for (const DecisionNumber& told : group.numbers)
      std::visit([&](auto value) { numbers[group.name][told.name] = value; }, told.value);
  return numbers;
}

void print_to_stdout(std::string_view document) {
  const std::string text = with_escaped_controls(document);
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw DataError({"standard output"}, std::string("cannot write: ") + std::strerror(errno));
  }
}

}  // namespace loopstone::app
