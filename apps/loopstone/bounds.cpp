#include "bounds.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"

namespace loopstone::app {

namespace {

void list_figures(const nlohmann::ordered_json& value, const std::string& prefix,
                  std::vector<std::string>& keys) {
  for (const auto& [key, child] : value.items()) {
    const std::string full = prefix.empty() ? key : prefix + "." + key;
    if (child.is_object()) list_figures(child, full, keys);
    if (child.is_number() || child.is_null()) keys.push_back(full);
  }
}

const nlohmann::ordered_json* find(const nlohmann::ordered_json& result, std::string_view key) {
  const nlohmann::ordered_json* place = &result;
  while (true) {
    const auto dot = key.find('.');
    const auto child = place->find(std::string(key.substr(0, dot)));
    if (!place->is_object() || child == place->end()) return nullptr;
    place = &*child;
    if (dot == std::string_view::npos) return place;
    key.remove_prefix(dot + 1);
  }
}

bool holds(double figure, const Bound& bound) {
  if (bound.relation == "<=") return figure <= bound.value;
  if (bound.relation == "<") return figure < bound.value;
  if (bound.relation == ">=") return figure >= bound.value;
  return figure > bound.value;
}

}  // namespace

Bound parse_bound(const std::string& text) {
  const UsageError wrong("--require " + text + ": must read like ate_rmse_m<=0.05 (or <, >=, >)");
  const auto at = text.find_first_of("<>");
  if (at == 0 || at == std::string::npos) throw wrong;
  const bool or_equal = at + 1 < text.size() && text[at + 1] == '=';
  const std::string number = text.substr(at + (or_equal ? 2 : 1));
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(number, &used);
  } catch (const std::exception&) {
    throw wrong;
  }
  if (used != number.size()) throw wrong;
  return {text.substr(0, at), text.substr(at, or_equal ? 2 : 1), value};
}

std::vector<std::string> missed_bounds(const std::vector<Bound>& bounds,
                                       const nlohmann::ordered_json& result) {
  std::vector<std::string> missed;
  for (const Bound& bound : bounds) {
    const nlohmann::ordered_json* figure = find(result, bound.key);
    if (figure == nullptr || !(figure->is_number() || figure->is_null())) {
      std::vector<std::string> keys;
      list_figures(result, {}, keys);
      const std::string nearest = nearest_key(bound.key, keys);
      throw UsageError(fmt::format("--require {}: the result has no figure of that name; {}",
                                   bound.key,
                                   nearest.empty() ? fmt::format("it has {}", fmt::join(keys, ", "))
                                                   : "did you mean " + nearest + "?"));
    }
    if (figure->is_null() || !holds(figure->get<double>(), bound)) {
      missed.push_back(fmt::format("{} is {}, required {} {}", bound.key, figure->dump(),
                                   bound.relation, bound.value));
    }
  }
  return missed;
}

std::vector<Bound> parse_bounds(const std::vector<std::string>& texts) {
  std::vector<Bound> bounds;
  for (const std::string& text : texts) bounds.push_back(parse_bound(text));
  return bounds;
}

void add_require_flag(CLI::App& command, std::vector<std::string>& texts, const std::string& help) {
  command.add_option("--require", texts, help)->type_name("KEY<=VALUE")->allow_extra_args(false);
}

ExitCode report_missed(const std::vector<std::string>& missed, const AppContext& context) {
  for (const std::string& text : missed) context.warn("bound missed: " + text);
  return missed.empty() ? kExitDone : kExitBoundMissed;
}

}  // namespace loopstone::app
