#include "loopstone/report/map_outputs.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <functional>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/map_picture.hpp"
#include "loopstone/report/quality_picture.hpp"
#include "loopstone/report/texture_picture.hpp"
#include "report/closure_csv.hpp"
#include "report/decisions.hpp"
#include "report/drive_part.hpp"
#include "report/edit_summary.hpp"
#include "report/landmark_summary.hpp"
#include "report/output_files.hpp"
#include "report/quality_summary.hpp"
#include "report/report_html.hpp"
#include "report/texture_files.hpp"
#include "report/texture_summary.hpp"
#include "report/trajectory_csv.hpp"
#include "report/with_peak_memory.hpp"
#include "report/written_states.hpp"

namespace loopstone {
namespace {

/// What took the run its time and no disk any room: it is kept, whatever becomes of the rest.
void add_trajectory_and_graph(const MapResult& result, const RunInfo& info, const MapExtras& extras,
                              FileSet& files) {
  const LandmarkMapping* const landmarks = extras.landmarks;
  files.add("trajectory.tum", "optimised pose of every scan: t x y z qx qy qz qw",
            format_tum(result.trajectory));
  if (!result.drives.empty()) {
    const std::vector<Trajectory> drives = result.trajectories();
    for (std::size_t i = 0; i < drives.size(); ++i) {
      files.add(drive_trajectory_name(i), "the poses of one drive, stamps of its own log",
                format_tum(drives[i]));
    }
  }
  if (result.covariances.available()) {
    files.add("trajectory.csv", "the same with covariances against the first pose",
              format_trajectory_csv(result));
  }
  files.add("odometry.tum", "the pose of every scan from odometry alone",
            format_tum(result.odometry));
  files.add("graph.g2o", "the final pose graph", format_g2o(result.graph));
  files.add("loop_closures.csv", "every place that was recognised or looked like it",
            format_closure_csv(result));
  files.add("options.toml", "the effective options", info.options_toml);
  std::vector<NumberGroup> decisions = decision_numbers();
  if (landmarks != nullptr) {
    files.add("landmarks.csv", "the landmarks, as loopstone localize --landmarks reads them",
              format_found_landmarks(landmarks->landmarks));
    decisions.push_back(landmark_numbers());
  }
  if (extras.edits != nullptr) std::ranges::move(edit_numbers(), std::back_inserter(decisions));
  files.add("decisions.toml", "what else the map was made and judged by",
            format_decisions(decisions));
}

void add_map_and_report(const MapResult& result, const RunInfo& info, const MapExtras& extras,
                        FileSet& files) {
  const FloorTexture* const texture = extras.texture;
  if (!result.map_failure.empty()) throw std::runtime_error(result.map_failure);
  const CellStates cells = states_to_write(result.map);
  std::string picture;
  std::string quality_picture;
  std::string floor_picture;
  std::string pgm;
  const std::span<const FoundLandmark> landmarks =
      extras.landmarks == nullptr ? std::span<const FoundLandmark>{} : extras.landmarks->landmarks;
  // The pictures take longest, so they come first.
  const std::vector<std::function<void()>> makers = {
      [&] { picture = encode_png(draw_map_picture(result, {}, landmarks), kPngCompression); },
      [&] {
        if (result.verdict.measures.empty()) return;
        quality_picture = encode_png(
            draw_quality_picture(result, {.target_side_px = kQualitySidePx}), kPngCompression);
      },
      [&] {
        if (texture == nullptr || texture->frame.cell_count() == 0) return;
        floor_picture = encode_png(draw_texture_picture(*texture, result.map, result.trajectory),
                                   kPngCompression);
      },
      [&] { pgm = encode_pgm(map_image(cells)); },
  };
  parallel_for(makers.size(), Threads{info.threads}, [&](std::size_t i) { makers[i](); });

  files.add("map.png", "the map, the path and the loop closures, to look at", picture);
  files.add("map.pgm", "occupancy as map_server reads it", pgm);
  files.add("map.yaml", "frame and thresholds of map.pgm",
            format_map_yaml(cells.frame(), "map.pgm"));
  std::string quality_html;
  if (!quality_picture.empty()) {
    files.add("quality.png", "where visits to the same place agree, and where not",
              quality_picture);
    quality_html = html_quality(result, quality_picture);
  }
  std::string floor_html;
  if (texture != nullptr) {
    add_texture_files(*texture, files);
    if (!floor_picture.empty()) {
      files.add("texture_map.png", "the floor under walls and path, to look at", floor_picture);
    }
    floor_html = html_texture(*texture, floor_picture);
  }
  if (extras.landmarks != nullptr) floor_html += html_landmarks(*extras.landmarks);
  if (extras.edits != nullptr) {
    add_edit_files(*extras.edits, cells.frame(), files);
    floor_html += html_edits(*extras.edits);
  }
  const RunInfo until_now = with_peak_memory(info);
  files.add("summary.json", "every figure of the run, for programs",
            format_summary(result, until_now, extras));
  files.add("report.html", "this page",
            format_report(result, until_now, picture, files.listed(), quality_html, floor_html));
  files.make_safe();
}

}  // namespace

void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir,
                       const MapExtras& extras) {
  OutputFolder folder(out_dir, info.force);
  FileSet files(folder);
  add_trajectory_and_graph(result, info, extras, files);
  files.make_safe();
  std::string failure;
  try {
    add_map_and_report(result, info, extras, files);
  } catch (const std::exception& error) {
    failure = error.what();
    files.forget_the_rest();
    RunInfo incomplete = with_peak_memory(info);
    incomplete.failure = failure;
    files.add("summary.json", "every figure of the run, for programs",
              format_summary(result, incomplete, {}));
  }
  files.commit();
  folder.keep();
  if (!failure.empty()) {
    throw std::runtime_error(failure + "; trajectory and graph are in " + out_dir +
                             ", where summary.json says that the rest is missing");
  }
}

}  // namespace loopstone
