#include "map_landmarks.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "loopstone/report/landmark_figures.hpp"

namespace loopstone::app {

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

ExitCode map_mrclam(const MapArguments&, const AppContext&) { return kExitDone; }

}  // namespace loopstone::app
