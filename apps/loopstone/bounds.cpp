#include "bounds.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"

namespace loopstone::app {

namespace {

/// Throws UsageError when there is none, naming the nearest one.
const SummaryFigure& find(const std::vector<SummaryFigure>& figures, const std::string& key) {
  const auto found = std::ranges::find(figures, key, &SummaryFigure::key);
  if (found != figures.end()) return *found;
  std::vector<std::string> keys;
  for (const SummaryFigure& figure : figures) keys.push_back(figure.key);
  const std::string nearest = nearest_key(key, keys);
  throw UsageError(fmt::format("--require {}: the result has no figure of that name; {}", key,
                               nearest.empty() ? fmt::format("it has {}", fmt::join(keys, ", "))
                                               : "did you mean " + nearest + "?"));
}

bool holds(double figure, const Bound& bound) {
  if (bound.relation == "<=") return figure <= bound.value;
  if (bound.relation == "<") return figure < bound.value;
  if (bound.relation == ">=") return figure >= bound.value;
  return figure > bound.value;
}

}  // namespace

Bound parse_bound(const std::string& text) {
  const auto wrong = [&] {
    return UsageError("--require " + text + ": must read like ate_rmse_m<=0.05 (or <, >=, >)");
  };
  const auto at = text.find_first_of("<>");
  if (at == 0 || at == std::string::npos) throw wrong();
  const bool or_equal = at + 1 < text.size() && text[at + 1] == '=';
  const std::string number = text.substr(at + (or_equal ? 2 : 1));
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(number, &used);
  } catch (const std::exception&) {
    throw wrong();
  }
  if (used != number.size()) throw wrong();
  return {text.substr(0, at), text.substr(at, or_equal ? 2 : 1), value};
}

std::vector<std::string> missed_bounds(const std::vector<Bound>& bounds,
                                       const std::vector<SummaryFigure>& figures) {
  std::vector<std::string> missed;
  for (const Bound& bound : bounds) {
    const std::optional<double> value = find(figures, bound.key).value;
    if (value && holds(*value, bound)) continue;
    missed.push_back(fmt::format("{} is {}, required {} {}", bound.key,
                                 value ? fmt::format("{}", *value) : "null", bound.relation,
                                 bound.value));
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
