#include "loopstone/report/landmark_outputs.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "formats/left_out_json.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/graph_picture.hpp"
#include "report/decisions.hpp"
#include "report/html_parts.hpp"
#include "report/landmark_summary.hpp"
#include "report/output_files.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"
#include "report/with_peak_memory.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

std::string picture_of(const LandmarkDriveMap& map) {
  GraphScene scene{.graph = &map.mapping.graph,
                   .before_title = "odometry alone",
                   .after_title = "with landmarks"};
  for (const StampedPose2& pose : map.odometry.poses()) scene.before.push_back(pose.pose);
  return encode_png(draw_graph_picture(scene), kPngCompression);
}

std::string report_of(const LandmarkDriveMap& map, const RunInfo& info, bool complete,
                      std::string_view picture, const std::vector<ListedFile>& files) {
  std::string body = "<p class=\"verdict\">";
  if (!complete) body += "<strong class=\"bad\">Incomplete: the run was stopped.</strong> ";
  body += fmt::format(
      "{} along {} m, from {}; no scans, so no map of surfaces.</p>\n",
      count_of(static_cast<std::int64_t>(map.mapping.landmarks.size()), "landmark", "landmarks"),
      readable(map.path_length_m),
      count_of(static_cast<std::int64_t>(map.trajectory.size()), "reading", "readings"));
  body += html_warnings(map.warnings);
  body += html_figure(html_picture(picture, "map", "Path and landmarks"),
                      "The path runs from blue (start) to orange (end); landmarks are dots.");
  body += html_landmarks(map.mapping);
  body += html_options(info) + html_file_list(files);
  return html_page("Landmarks of " + log_name(info), body, info);
}

}  // namespace

std::string format_summary(const LandmarkDriveMap& map, const RunInfo& info, bool complete) {
  Json summary{{"version", info.version},
               {"log", info.log_path},
               {"command", info.command_line},
               {"complete", complete},
               {"scans", 0},
               {"readings", map.trajectory.size()},
               {"records_skipped", info.left_out.skipped.records},
               {"left_out", to_json(info.left_out)},
               {"path_length_m", map.path_length_m},
               {"duration_s", map.duration_s},
               {"wall_time_s", info.wall_time_s},
               {"cpu_time_s", info.cpu_time_s},
               {"realtime_factor", ratio_or_zero(map.duration_s, info.wall_time_s)},
               {"threads", info.threads},
               {"peak_memory_bytes", info.peak_memory_bytes},
               {"graph_nodes", map.mapping.graph.poses.size()},
               {"graph_edges", map.mapping.graph.edges.size()},
               {"graph_cost", graph_cost(map.mapping.graph)},
               {"landmarks", landmarks_json(map.mapping)},
               {"warnings", map.warnings}};
  // Paths need not be UTF-8; JSON must.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_landmark_outputs(const LandmarkDriveMap& map, const RunInfo& info, bool complete,
                            const std::string& out_dir) {
  OutputFolder folder(out_dir, info.force);
  FileSet files(folder);
  files.add("trajectory.tum", "optimised pose at every reading: t x y z qx qy qz qw",
            format_tum(map.trajectory));
  files.add("odometry.tum", "the same from odometry alone", format_tum(map.odometry));
  files.add("graph.g2o", "the final graph of poses and landmarks", format_g2o(map.mapping.graph));
  files.add("landmarks.csv", "the landmarks, as loopstone localize --landmarks reads them",
            format_found_landmarks(map.mapping.landmarks));
  files.add("options.toml", "the effective options", info.options_toml);
  const std::vector<NumberGroup> decisions{landmark_numbers()};
  files.add("decisions.toml", "what else the map was made by", format_decisions(decisions));
  const std::string picture = picture_of(map);
  files.add("map.png", "path and landmarks, to look at", picture);
  const RunInfo until_now = with_peak_memory(info);
  files.add("summary.json", "every figure of the run, for programs",
            format_summary(map, until_now, complete));
  files.add("report.html", "this page",
            report_of(map, until_now, complete, picture, files.listed()));
  files.make_safe();
  files.commit();
  folder.keep();
}

}  // namespace loopstone
