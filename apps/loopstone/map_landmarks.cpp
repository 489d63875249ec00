#include "map_landmarks.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/localization/landmark_drive.hpp"
#include "loopstone/report/landmark_figures.hpp"
#include "loopstone/report/landmark_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "mrclam_run.hpp"
#include "output_path.hpp"

namespace loopstone::app {
namespace {

/// What a log without scans has no use for.
void refuse_flags_of_scans(const MapArguments& arguments) {
  const auto refuse = [&](const std::string& flag) {
    throw UsageError(fmt::format("{}: {} holds landmarks and odometry, no scans; leave it out",
                                 flag, arguments.log));
  };
  if (!arguments.landmarks.on) {
    throw UsageError(arguments.log +
                     ": holds landmarks and odometry, no scans; --landmarks maps them");
  }
  if (arguments.pipeline != Pipeline::kSubmaps) refuse("--pipeline");
  if (arguments.checkpoint.any()) refuse("--checkpoint, --resume");
  if (arguments.drives.any()) refuse("--keep-state, --continue");
  if (!arguments.mcap.empty()) refuse("--mcap");
  if (arguments.view) refuse("--view");
  if (arguments.realtime > 0.0) refuse("--realtime");
  if (arguments.cloud) refuse("--cloud");
  if (arguments.odometry) refuse("--odometry");
  if (arguments.landmarks.brightness) refuse("--reflector-threshold");
}

ExitCode tell(const LandmarkDriveMap& map, const RunInfo& info, bool complete,
              const std::string& out, const AppContext& context) {
  for (const std::string& warning : map.warnings) context.warn(warning);
  if (context.json()) {
    print_to_stdout(format_summary(map, info, complete));
  } else {
    Result table;
    table.add("readings", "readings", static_cast<std::int64_t>(map.trajectory.size()));
    table.add("duration_s", "recording", map.duration_s, "s", 1);
    table.add("path_length_m", "path", map.path_length_m, "m", 1);
    add_landmark_rows(map.mapping, table);
    table.add_row("time", fmt::format("{:.2f} s", info.wall_time_s));
    table.add_row("report", out + "/report.html");
    table.print(context);
  }
  if (complete) return kExitDone;
  context.warn("interrupted: the map is of what was read until then");
  return kExitInterrupted;
}

}  // namespace

void add_landmark_map_flags(CLI::App& command, LandmarkMapFlags& flags) {
  command.add_flag("--landmarks", flags.on,
                   "also map reflectors, by the intensities of the scans, or the landmarks of an "
                   "MRCLAM folder, and let them hold the map: landmarks.csv");
  command.add_flag("--nameless", flags.nameless,
                   "of --landmarks: do not use which landmark was seen");
  command
      .add_option("--reflector-threshold", flags.brightness,
                  "of --landmarks: so many times brighter than usual at its range a beam on a "
                  "reflector is (default: option landmarks.reflectors.brightness)")
      ->type_name("N");
}

void add_landmark_rows(const LandmarkMapping& mapping, Result& table) {
  const LandmarkFigures figures = figures_of(mapping);
  table.add_row("landmarks",
                fmt::format("{}, known to {:.0f} mm (mean), {:.0f} sightings each", figures.count,
                            1e3 * figures.sigma_mean_m, figures.sightings_mean));
}

ExitCode map_mrclam(const MapArguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  refuse_flags_of_scans(arguments);
  LandmarkMapOptions options = landmark_map_options(arguments.landmarks, context);
  Outputs outputs(context, arguments.force);
  for (const std::string& file : mrclam_log_files(arguments.log)) outputs.reads(file);
  outputs.add_folder("-o", arguments.out, false);
  outputs.check();
  const MrclamLog log =
      read_mrclam_run(arguments.log, arguments.reading, options.landmarks.sightings, context);
  const auto readings = readings_within(log, arguments.cut, arguments.landmarks.nameless);
  if (readings.empty()) {
    throw DataError({arguments.log},
                    "nothing was seen in the part that --start, --duration and "
                    "--max-scans leave");
  }
  outputs.prepare();
  const LandmarkDriveMap map =
      map_drive(drive_among_landmarks(log.odometry, readings), options.landmarks);
  RunInfo info = run_info(arguments.log, left_out_of(log), arguments.force, context);
  info.options_toml = options_to_toml(list_options(options));
  info.cpu_time_s = cpu_seconds();
  info.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  info.peak_memory_bytes = peak_memory_bytes();
  write_landmark_outputs(map, info, !interrupted(), arguments.out);
  return tell(map, info, !interrupted(), arguments.out, context);
}

}  // namespace loopstone::app
