#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// Estimates as comma-separated values: a line of column names, then one line an estimate.
///
///   t_s,x_m,y_m,yaw_rad,
///     map_T_robot
///   xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,
///     its covariance, upper triangle
///   state,probability,refined,hypotheses,particles,landmarks,travelled_m,
///     TRACKING, DOUBTFUL or LOST; refined 0 or 1
///   explained,violations,unexpected,mass,precision,spread_m,spread_rad,innovation,followed_m
///     what the probability stands on
///
/// Stamps have nine decimals, other numbers as many digits as bring the same value back; what is
/// not finite is empty.
[[nodiscard]] std::string format_localization_csv(
    const std::vector<LocalizationEstimate>& estimates);

/// Reads what format_localization_csv writes, columns in any order; unknown columns are passed
/// over, those of the evidence may be missing. Empty is NaN. Throws DataError with the line for
/// anything else.
[[nodiscard]] std::vector<LocalizationEstimate> parse_localization_csv(
    std::string_view text, const std::string& path_for_errors = "localization");

void write_localization_csv(const std::string& path,
                            const std::vector<LocalizationEstimate>& estimates);
[[nodiscard]] std::vector<LocalizationEstimate> read_localization_csv(
    const std::string& path, const MemoryBudget& budget = {});

}  // namespace loopstone
