#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "log_run.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/localization/localizer.hpp"
#include "progress_display.hpp"

// `loopstone localize --landmarks`: what differs from a map of cells.

namespace loopstone::app {

/// What a user says of landmarks.
struct LandmarkArguments {
  std::string file;                    ///< empty: the map is one of cells
  bool nameless = false;               ///< identities of what was seen are not used
  std::optional<double> brightness{};  ///< of a beam on a reflector
};

/// --landmarks, --nameless, --reflector-threshold.
void add_landmark_flags(CLI::App& command, LandmarkArguments& arguments);

/// A run among landmarks, as one on a map of cells leaves it.
struct LandmarkRun {
  LocalizationResult result{};
  Grid<std::int8_t> drawing{};  ///< of the landmarks, to look at
  LeftOut left_out{};
  std::string options_toml;
};

/// The files that are read beside the landmarks' own: of a log, or of an MRCLAM folder.
[[nodiscard]] std::vector<std::string> landmark_log_files(const std::string& log);

/// Reads landmarks and log, and follows the robot. Throws DataError where nothing can be made of
/// them.
[[nodiscard]] LandmarkRun localize_by_landmarks(const LandmarkArguments& arguments,
                                                const std::string& log, const LogFlags& reading,
                                                const LogCut& cut,
                                                const std::optional<InitialPose>& initial,
                                                double snapshot_distance_m,
                                                const AppContext& context);

}  // namespace loopstone::app
