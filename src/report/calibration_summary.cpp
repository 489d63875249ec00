#include "report/calibration_summary.hpp"

#include <fmt/format.h>

#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "report/html_parts.hpp"
#include "report/text.hpp"

namespace loopstone {

namespace {

nlohmann::ordered_json to_json(const CalibratedValue& value) {
  return {{"value", value.value},
          {"sigma", value.sigma},
          {"given", value.given},
          {"observable", value.observable}};
}

HtmlRow row(const char* name, const CalibratedValue& value, double unit, const char* unit_name,
            int digits) {
  if (!value.observable) return {name, "not observable"};
  return {name, fmt::format("{:.{}f} ± {:.{}f} {}", unit * value.value, digits, unit * value.sigma,
                            digits, unit_name)};
}

}  // namespace

nlohmann::ordered_json calibration_json(const Calibration& calibration) {
  const nlohmann::ordered_json beams = {{"laser_is_mirrored", calibration.laser_is_mirrored},
                                        {"mirror_is_in_doubt", calibration.mirror_is_in_doubt},
                                        {"sweep_s", to_json(calibration.sweep_s)},
                                        {"sweep_is_off", calibration.sweep_is_off},
                                        {"corrected", calibration.beams_corrected}};
  const nlohmann::ordered_json open_travel = {{"odometry_scale", calibration.odometry_scale},
                                              {"error_m", calibration.open_travel_error_m},
                                              {"scale_is_off", calibration.scale_is_off},
                                              {"corrected", calibration.scale_corrected}};
  if (calibration.motions == 0)
    return {{"motions", 0}, {"beams", beams}, {"open_travel", open_travel}};
  return {{"motions", calibration.motions},
          {"mount_corrected", calibration.is_corrected},
          {"several_mounts", calibration.several_mounts},
          {"beams", beams},
          {"open_travel", open_travel},
          {"lidar",
           {{"index", calibration.lidar},
            {"x_m", to_json(calibration.lidar_x_m)},
            {"y_m", to_json(calibration.lidar_y_m)},
            {"yaw_rad", to_json(calibration.lidar_yaw_rad)},
            {"yaw_is_off", calibration.yaw_is_off},
            {"place_is_off", calibration.place_is_off}}},
          {"odometry",
           {{"translation_scale", to_json(calibration.translation_scale)},
            {"rotation_scale", to_json(calibration.rotation_scale)},
            {"turn_bias_rad_s", to_json(calibration.turn_bias_rad_s)},
            {"turn_per_m_rad", to_json(calibration.turn_per_m_rad)}}},
          {"laser_delay_s", to_json(calibration.laser_delay_s)}};
}

std::string calibration_html(const Calibration& calibration) {
  if (calibration.motions == 0) return {};
  const std::string mount =
      calibration.is_corrected ? "Laser's mount, corrected on this map" : "Laser's mount";
  return "<h2>Calibration</h2>\n<p class=\"soft\">What the motions of laser and odometry tell of "
         "one another, each with one standard deviation.</p>\n<div class=\"figures\">\n" +
         html_key_table(mount,
                        {row("ahead of the centre", calibration.lidar_x_m, 1e3, "mm", 1),
                         row("left of it", calibration.lidar_y_m, 1e3, "mm", 1),
                         row("looks left by", calibration.lidar_yaw_rad, degrees(1.0), "deg", 3),
                         row("scans later than stamped", calibration.laser_delay_s, 1e3, "ms", 1),
                         row("sweep that is not told", calibration.sweep_s, 1e3, "ms", 1)}) +
         html_key_table(
             "Odometry",
             {row("its way / the laser's", calibration.translation_scale, 1.0, "", 4),
              row("its turns / the laser's", calibration.rotation_scale, 1.0, "", 4),
              row("turns while standing", calibration.turn_bias_rad_s, degrees(1.0), "deg/s", 3),
              row("turns going straight", calibration.turn_per_m_rad, degrees(1.0), "deg/m", 3)}) +
         "</div>\n";
}

}  // namespace loopstone
