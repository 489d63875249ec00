#pragma once

#include <cstdint>
#include <optional>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_calibration.hpp"
#include "loopstone/pipeline/log_source.hpp"

namespace loopstone {

/// Where the robot of a log was on a known map.
struct LogLocalization {
  LocalizationResult result{};
  LogSummary log{};
};

/// As `loopstone localize LOG` does it, without what that writes. Throws DataError when nothing can
/// be made of the log. What was called off has a result that is not complete.
/// \param reader  of the source, at its beginning
/// \param robot   robot_as_driven(), or as it is told
/// \param seed    of the particles
[[nodiscard]] LogLocalization localize_log(const LogSource& source, LogReader& reader,
                                           const DrivenRobot& robot, const LocalizationMap& map,
                                           const LocalizationOptions& options,
                                           const std::optional<InitialPose>& initial,
                                           std::uint64_t seed, const LogCut& cut,
                                           Threads threads = {}, const ReadingWatch& watch = {});

}  // namespace loopstone
