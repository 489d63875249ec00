#include "report/edit_summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "loopstone/formats/filter_mask_file.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/geometry/angle.hpp"
#include "report/html_parts.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"

namespace loopstone {

namespace {

using Json = nlohmann::ordered_json;

Json shift_json(const MapShift& shift) {
  return {
      {"mean_m", shift.mean_m}, {"largest_m", shift.largest_m}, {"largest_rad", shift.largest_rad}};
}

Json closure_json(const LoopClosure& closure) {
  return {{"from_node", closure.from.index},
          {"to_node", closure.to.index},
          {"from_submap", closure.from_submap.index},
          {"to_submap", closure.to_submap.index},
          {"x_m", closure.from_T_to.x},
          {"y_m", closure.from_T_to.y},
          {"yaw_rad", closure.from_T_to.yaw},
          {"score", closure.score},
          {"overlap", closure.overlap},
          {"agreement", closure.agreement},
          {"sigma_x_m", std::sqrt(closure.covariance(0, 0))},
          {"sigma_y_m", std::sqrt(closure.covariance(1, 1))},
          {"sigma_yaw_rad", std::sqrt(closure.covariance(2, 2))},
          {"chi2", optional_number(closure.chi2)}};
}

Json edit_json(const ToldEdit& told) {
  const EditReport& report = told.report;
  Json json{{"kind", told.kind},
            {"applied", report.applied},
            {"told", report.told},
            {"shift", shift_json(report.shift)},
            {"closures_revoked", report.closures_revoked},
            {"reduced_chi2_before", report.reduced_chi2_before},
            {"reduced_chi2", report.reduced_chi2},
            {"graph_verdict_before", to_string(report.verdict_before)},
            {"graph_verdict", to_string(report.verdict)},
            {"wall_s", report.seconds}};
  if (report.closure) json["closure"] = closure_json(*report.closure);
  return json;
}

template <typename Zone>
Json zone_json(const Zone& zone) {
  Json corners = Json::array();
  for (const Eigen::Vector2d& corner : zone.polygon.corners)
    corners.push_back({corner.x(), corner.y()});
  return {{"name", zone.name}, {"polygon_m", corners}};
}

Json zones_json(const EditOutputs& edits) {
  Json zones{{"keep_out", Json::array()}, {"speed", Json::array()}};
  for (const KeepOutZone& zone : edits.keep_out) zones["keep_out"].push_back(zone_json(zone));
  for (const SpeedZone& zone : edits.speed) {
    Json json = zone_json(zone);
    json[zone.unit == SpeedUnit::kPercent ? "percent" : "limit_m_s"] = zone.limit;
    zones["speed"].push_back(std::move(json));
  }
  return zones;
}

void add_mask(const std::string& name, const std::string& content, const FilterMask& mask,
              FileSet& files) {
  files.add(name + ".pgm", content + ", for nav2", encode_pgm(mask_image(mask)));
  files.add(name + ".yaml", "frame and meaning of " + name + ".pgm",
            format_mask_yaml(mask.values.frame(), name + ".pgm"));
}

}  // namespace

nlohmann::ordered_json edits_json(const EditOutputs& edits) {
  Json list = Json::array();
  for (const ToldEdit& told : edits.edits) list.push_back(edit_json(told));
  return {
      {"edited", edits.edited},
      {"list", std::move(list)},
      {"shift", shift_json(edits.shift)},
      {"new_T_map",
       {{"x_m", edits.new_T_map.x}, {"y_m", edits.new_T_map.y}, {"yaw_rad", edits.new_T_map.yaw}}},
      {"cells_erased", edits.cells_erased},
      {"verdict_before", to_string(edits.verdict_before)},
      {"zones", zones_json(edits)},
      {"open_wall_s", edits.open_s},
      {"edit_wall_s", edits.edit_s},
      {"draw_wall_s", edits.draw_s}};
}

std::string format_edits(const EditOutputs& edits) {
  return edits_json(edits).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string html_edits(const EditOutputs& edits) {
  std::vector<HtmlRow> rows;
  for (std::size_t i = 0; i < edits.edits.size(); ++i) {
    const ToldEdit& edit = edits.edits[i];
    std::string text = edit.report.told;
    if (edit.report.shift.largest_m > 0.0) {
      text +=
          fmt::format("; key scans moved by {:.3f} m on average, {:.3f} m and {:.2f} deg at most",
                      edit.report.shift.mean_m, edit.report.shift.largest_m,
                      degrees(edit.report.shift.largest_rad));
    }
    rows.push_back({fmt::format("{}. {}", i + 1, escape_html(edit.kind)), escape_html(text)});
  }
  if (rows.empty()) rows.push_back({"none", "the map as it was"});
  return "<h2>Edits by hand</h2>\n<div class=\"figures\">\n" +
         html_key_table("What was done to " + escape_html(edits.edited), rows) + "</div>\n";
}

void add_edit_files(const EditOutputs& edits, const GridFrame& frame, FileSet& files) {
  files.add("edits.toml", "the edits that were done by hand", edits.edits_toml);
  std::optional<FilterMask> keep_out;
  std::optional<FilterMask> speed;
  if (!edits.keep_out.empty()) {
    keep_out = keep_out_mask(frame, edits.keep_out);
    add_mask("keepout_mask", "where a robot must not go", *keep_out, files);
  }
  if (!edits.speed.empty()) {
    speed = speed_mask(frame, edits.speed);
    add_mask("speed_mask", "where a robot goes slowly", *speed, files);
  }
  if (keep_out || speed) {
    files.add("nav2_filters.yaml", "parameters of nav2 that read the masks",
              format_nav2_filters(keep_out ? &*keep_out : nullptr, speed ? &*speed : nullptr));
  }
}

}  // namespace loopstone
