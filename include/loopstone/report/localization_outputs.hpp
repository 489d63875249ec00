#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/report/run_info.hpp"
#include "loopstone/report/summary_figure.hpp"

namespace loopstone {

/// What the program knows about a localisation that its result does not.
struct LocalizationRunInfo {
  RunInfo run{};
  std::string map_path;                  ///< as the user gave it
  std::optional<InitialPose> initial{};  ///< nothing: from anywhere on the map
  std::uint64_t seed = 1;
  double map_free_area_m2 = 0.0;
  std::int64_t map_memory_bytes = 0;  ///< of the map made ready
};

/// Writes trajectory.tum, localization.csv, map.png, report.html, summary.json and options.toml.
/// All of them are complete on disk before the first gets its name, so a full disk leaves none of
/// them behind. Makes the folder when it is missing. Throws UsageError when it holds something and
/// `run.force` is false, DataError naming the file that can't be written.
/// \param occupancy  the map, in percent, -1 unknown
void write_localization_outputs(const LocalizationResult& result,
                                const Grid<std::int8_t>& occupancy, const LocalizationRunInfo& info,
                                const std::string& out_dir);

/// The trajectory as TUM and beside it, under the same name with .csv, every estimate with
/// covariance, state and evidence (formats/localization_csv.hpp): both or none. Into a pipe or
/// device goes the trajectory alone.
/// Returns the name of the CSV file; empty when there is none. Throws UsageError when the
/// trajectory itself is to be a .csv.
std::string write_localization_trajectory(const LocalizationResult& result,
                                          const std::string& tum_path);

/// One PNG a snapshot of the belief, 000001.png onwards, all of one size, drawn and written one
/// after the other. Makes the folder when it is missing; throws as write_localization_outputs does.
/// Returns how many there are.
std::int64_t write_localization_animation(const LocalizationResult& result,
                                          const Grid<std::int8_t>& occupancy,
                                          const std::string& out_dir, bool force);

/// The text of summary.json: one object, every figure of the run, units in the key names, keys in a
/// fixed order.
[[nodiscard]] std::string format_summary(const LocalizationResult& result,
                                         const Grid<std::int8_t>& occupancy,
                                         const LocalizationRunInfo& info);
/// Each number of that summary, in its order.
[[nodiscard]] std::vector<SummaryFigure> summary_figures(const LocalizationResult& result,
                                                         const Grid<std::int8_t>& occupancy,
                                                         const LocalizationRunInfo& info);

}  // namespace loopstone
