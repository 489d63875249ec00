#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace loopstone::app {

/// A demand on a figure of the result, for scripts: "ate_rmse_m<=0.05".
struct Bound {
  std::string key;       ///< of the JSON result, dots for nesting
  std::string relation;  ///< "<=", "<", ">=", ">"
  double value = 0.0;
};

/// Throws UsageError when the text is none.
[[nodiscard]] Bound parse_bound(const std::string& text);

/// One sentence for each bound that the result misses. A figure that is null misses every bound.
/// Throws UsageError when the result has no such figure, naming the nearest one.
[[nodiscard]] std::vector<std::string> missed_bounds(const std::vector<Bound>& bounds,
                                                     const nlohmann::ordered_json& result);

}  // namespace loopstone::app
