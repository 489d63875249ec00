#pragma once

#include <optional>
#include <string>

namespace loopstone {

/// A number of a summary, for who holds it against a bound.
struct SummaryFigure {
  std::string key;                ///< as in the summary's JSON, dots for nesting; ends in its unit
  std::optional<double> value{};  ///< nothing where the JSON has null
};

}  // namespace loopstone
