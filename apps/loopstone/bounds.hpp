#pragma once

#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/report/summary_figure.hpp"

namespace loopstone::app {

/// A demand on a figure of the result, for scripts: "ate_rmse_m<=0.05".
struct Bound {
  std::string key;       ///< of the JSON result, dots for nesting
  std::string relation;  ///< "<=", "<", ">=", ">"
  double value = 0.0;
};

/// --require, which may be given several times.
void add_require_flag(
    CLI::App& command, std::vector<std::string>& texts,
    const std::string& help = "a bound on a figure of --json's result; may be given several times");

/// Throws UsageError when the text is none.
[[nodiscard]] Bound parse_bound(const std::string& text);
[[nodiscard]] std::vector<Bound> parse_bounds(const std::vector<std::string>& texts);

/// One sentence for each bound that the figures of a result miss. A figure that is null misses
/// every bound. Throws UsageError when there is no such figure, naming the nearest one.
[[nodiscard]] std::vector<std::string> missed_bounds(const std::vector<Bound>& bounds,
                                                     const std::vector<SummaryFigure>& figures);

/// Warns of what was missed; the exit code that scripts see.
[[nodiscard]] ExitCode report_missed(const std::vector<std::string>& missed,
                                     const AppContext& context);

}  // namespace loopstone::app
