#pragma once

#include <string>
#include <vector>

#include "log_run.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/sensor/landmark_reading.hpp"

// What commands that read MRCLAM's folders share.

namespace loopstone::app {

/// Says what it holds and what is left out. Throws DataError where none of what was seen is a
/// landmark.
[[nodiscard]] MrclamLog read_mrclam_run(const std::string& path, const LogFlags& flags,
                                        const SightingNoise& noise, const AppContext& context);

/// Readings within the cut.
/// \param nameless  identities of what was seen are left out
[[nodiscard]] std::vector<LandmarkReading> readings_within(const MrclamLog& log, const LogCut& cut,
                                                           bool nameless);

/// How much was read of it, and what not.
[[nodiscard]] LeftOut left_out_of(const MrclamLog& log);

}  // namespace loopstone::app
