#include "loopstone/report/map_outputs.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/map_picture.hpp"
#include "loopstone/report/quality_picture.hpp"
#include "loopstone/report/texture_picture.hpp"
#include "report/closure_csv.hpp"
#include "report/output_files.hpp"
#include "report/quality_summary.hpp"
#include "report/report_html.hpp"
#include "report/texture_files.hpp"
#include "report/texture_summary.hpp"

namespace loopstone {
namespace {

/// Places of 50 cm need fewer pixels than walls.
constexpr int kQualitySidePx = 1200;

/// A run that ended before its first scan still leaves a map that every tool can open: one unknown cell.
CellStates states_to_write(const OccupancyMap& map) {
  if (!map.log_odds.empty()) return cell_states(map);
  const GridFrame frame{.resolution = OccupancyOptions{}.resolution_m, .columns = 1, .rows = 1};
  return CellStates(frame, kUnknownCell);
}

}  // namespace

void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir,
                       const FloorTexture* texture) {
  OutputFolder folder(out_dir, info.force);
  const CellStates cells = states_to_write(result.map);
  std::string picture;
  std::string quality_picture;
  std::string floor_picture;
  std::string pgm;
  std::string trajectory;
  std::string odometry;
  std::string graph;
  std::string closures;
  // The pictures take longest, so they come first.
  const std::vector<std::function<void()>> makers = {
      [&] { picture = encode_png(draw_map_picture(result), kPngCompression); },
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
      [&] { trajectory = format_tum(result.trajectory); },
      [&] { odometry = format_tum(result.odometry); },
      [&] { graph = format_g2o(result.graph); },
      [&] { closures = format_closure_csv(result); },
      [&] { pgm = encode_pgm(map_image(cells)); },
  };
  parallel_for(makers.size(), Threads{info.threads}, [&](std::size_t i) { makers[i](); });

  FileSet files(folder);
  files.add("map.png", "the map, the path and the loop closures, to look at", picture);
  files.add("map.pgm", "occupancy as map_server reads it", pgm);
  files.add("map.yaml", "frame and thresholds of map.pgm",
            format_map_yaml(cells.frame(), "map.pgm"));
  files.add("trajectory.tum", "optimised pose of every scan: t x y z qx qy qz qw", trajectory);
  files.add("odometry.tum", "the same from odometry alone", odometry);
  files.add("graph.g2o", "the final pose graph", graph);
  files.add("loop_closures.csv", "every place that was recognised or looked like it", closures);
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
  files.add("options.toml", "the effective options", info.options_toml);
  files.add("summary.json", "every figure of the run, for programs",
            format_summary(result, info, texture));
  files.add("report.html", "this page",
            format_report(result, info, picture, files.listed(), quality_html, floor_html));
  files.commit();
  folder.keep();
}

}  // namespace loopstone
