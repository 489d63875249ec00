#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/pipeline/site.hpp"
#include "mapping.hpp"

namespace loopstone::python {

/// The map of a site: a result of all its sessions, and what only sites have.
struct SiteMapped : Mapped {
  Grid<float> movable{};
  std::optional<SiteGrids> grids{};  ///< not of changes
  std::vector<SiteSession> sessions{};
  MappedScans scans{};  ///< where they were to be kept
  std::vector<SiteCorrection> edits{};
};

/// As Python has it, in UTC, to the microsecond.
[[nodiscard]] nanobind::object to_datetime(Stamp stamp);

}  // namespace loopstone::python
