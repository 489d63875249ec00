#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/mapping/glass_survey.hpp"
#include "loopstone/mapping/visit_coverage.hpp"

namespace loopstone {

/// What was corrected by hand.
struct SiteEditFigure {
  std::int64_t edit = 0;  ///< its number
  std::string kind{};
  std::optional<std::int64_t> cells{};  ///< that lie in its polygon; nothing: a session is left out
};

/// Figures of a site's grids.
struct SiteFigures {
  std::size_t sessions = 0;
  CoverageFigures floor{};
  int most_passes = 0;                ///< of one cell
  std::optional<double> speed_m_s{};  ///< mean of all passes over all cells; nothing: none drove
  std::optional<double> speed_low_m_s{};   ///< of ten cells one is driven slower
  std::optional<double> speed_high_m_s{};  ///< and one faster
  std::vector<GlassPane> panes{};          ///< that are suspected
  std::vector<SiteEditFigure> edits{};
};

}  // namespace loopstone
