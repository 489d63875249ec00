#include "report/texture_summary.hpp"

#include <fmt/format.h>

#include "loopstone/geometry/angle.hpp"
#include "report/html_parts.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

std::string signed_value(double value, int digits, const char* unit) {
  return fmt::format("{:+.{}f} {}", value, digits, unit);
}

std::string clock_text(const CameraClock& clock) {
  if (clock.status == ClockStatus::kNotObserved) return "not observed";
  return fmt::format("{:+.1f} ± {:.1f} ms{}", 1e3 * clock.late_s, 1e3 * clock.sigma_s,
                     clock.is_significant() ? ", corrected" : "");
}

}  // namespace

nlohmann::ordered_json texture_json(const FloorTexture& texture) {
  const TextureStatistics& s = texture.statistics;
  const FloorEstimate& floor = texture.floor;
  const CameraClock& clock = texture.clock;
  return {
      {"complete", texture.complete},
      {"resolution_m", texture.cells.resolution_m()},
      {"seen_area_m2", s.seen_area_m2},
      {"filled_area_m2", s.filled_area_m2},
      {"columns", texture.frame.columns},
      {"rows", texture.frame.rows},
      {"frames", s.frames},
      {"frames_used", s.frames_used},
      {"frames_still", s.frames_still},
      {"frames_without_pose", s.frames_without_pose},
      {"frames_tilted", s.frames_tilted},
      {"frames_unreadable", s.frames_unreadable},
      {"brightness_spread", s.gain_spread},
      {"memory_bytes", s.memory_bytes},
      {"cloud_points", texture.cloud.size()},
      {"floor",
       {{"status", to_string(floor.status)},
        {"pitch_error_deg", degrees(floor.pitch_error_rad)},
        {"roll_error_deg", degrees(floor.roll_error_rad)},
        {"height_error_m", floor.height_error_m},
        {"pitch_scatter_deg", degrees(floor.pitch_scatter_rad)},
        {"noise_per_m", floor.noise_per_m},
        {"points", floor.points},
        {"frames", floor.frames}}},
      {"clock",
       {{"status", to_string(clock.status)},
        {"late_s", clock.late_s},
        {"sigma_s", clock.sigma_s},
        {"pairs", clock.pairs},
        {"significant", clock.is_significant()}}},
  };
}

std::string html_texture(const FloorTexture& texture, std::string_view picture_png) {
  const TextureStatistics& s = texture.statistics;
  const FloorEstimate& floor = texture.floor;
  std::string html = "<h2>Floor</h2>\n";
  if (texture.frame.cell_count() == 0) {
    return html + "<p>The camera's frames show no floor that could be put on the map.</p>\n";
  }
  html += html_figure(
      html_picture(picture_png, "map", "The floor in its colours under the map's walls"),
      "The floor as the camera saw it, the walls of the map over it. Grey and "
      "white: not seen by the camera.");
  html += "<div class=\"figures\">\n";
  html += html_key_table("Texture", {{"seen", readable(s.seen_area_m2) + " m²"},
                                     {"gaps filled", readable(s.filled_area_m2) + " m²"},
                                     {"cell", readable(1e3 * texture.cells.resolution_m()) + " mm"},
                                     {"brightness of the frames",
                                      "± " + readable(100.0 * s.gain_spread) + " %, levelled"}});
  html += html_key_table(
      "Camera's mount",
      floor.status == FloorStatus::kEstimated
          ? std::vector<HtmlRow>{{"pitch against the robot file",
                                  signed_value(degrees(floor.pitch_error_rad), 2, "deg")},
                                 {"roll", signed_value(degrees(floor.roll_error_rad), 2, "deg")},
                                 {"height", signed_value(100.0 * floor.height_error_m, 2, "cm")},
                                 {"scatter of the pitch over the frames",
                                  readable(degrees(floor.pitch_scatter_rad)) + " deg"}}
          : std::vector<HtmlRow>{{"floor", "not seen; the robot file is trusted"}});
  html += html_key_table("Frames", {{"with depth and colour", with_thousands(s.frames)},
                                    {"used", with_thousands(s.frames_used)},
                                    {"robot stood still", with_thousands(s.frames_still)},
                                    {"without a pose", with_thousands(s.frames_without_pose)},
                                    {"floor tilted", with_thousands(s.frames_tilted)},
                                    {"unreadable", with_thousands(s.frames_unreadable)},
                                    {"stamps late by", clock_text(texture.clock)}});
  return html + "</div>\n";
}

}  // namespace loopstone
