#pragma once

#include <string>

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// Figures of the report: probability, evidence, spread and hypotheses over time, each over bands
/// of the state.
[[nodiscard]] std::string localization_plots(const LocalizationResult& result);

}  // namespace loopstone
