#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/left_out_json.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "report/localization_figures.hpp"
#include "report/summary.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

Json pose_json(const LocalizationEstimate& estimate) {
  return {{"stamp_s", estimate.stamp.seconds()},
          {"x_m", estimate.map_T_robot.x},
          {"y_m", estimate.map_T_robot.y},
          {"yaw_rad", estimate.map_T_robot.yaw},
          {"sigma_x_m", std::sqrt(estimate.covariance(0, 0))},
          {"sigma_y_m", std::sqrt(estimate.covariance(1, 1))},
          {"sigma_yaw_rad", std::sqrt(estimate.covariance(2, 2))},
          {"state", to_string(estimate.state)},
          {"probability", estimate.probability}};
}

Json initial_json(const std::optional<InitialPose>& initial) {
  if (!initial) return {};
  return {{"x_m", initial->map_T_robot.x},
          {"y_m", initial->map_T_robot.y},
          {"yaw_rad", initial->map_T_robot.yaw},
          {"sigma_m", initial->sigma_m},
          {"sigma_rad", initial->sigma_rad}};
}

/// All that is known of a run.
Json summary_json(const LocalizationResult& result, const Grid<std::int8_t>& occupancy,
                  const LocalizationRunInfo& info) {
  const LocalizationFigures figures = figures_of(result);
  const RunInfo& run = info.run;
  std::int64_t whole_map = 0;
  for (const LocalizationSearch& search : result.searches) whole_map += search.whole_map ? 1 : 0;
  // Key order is the order of this list. A number that is not finite becomes null.
  return {
      {"version", run.version},
      {"log", run.log_path},
      {"map", info.map_path},
      {"command", run.command_line},
      {"complete", result.complete},
      {"start", info.initial ? "initial" : "global"},
      {"initial", initial_json(info.initial)},
      {"seed", info.seed},
      {"scans", result.scans},
      {"scans_dropped", result.scans_dropped},
      {"records_skipped", run.left_out.skipped.records},
      {"left_out", to_json(run.left_out)},
      {"poses", result.estimates.size()},
      {"poses_refined", figures.refined},
      {"had_odometry", result.had_odometry},
      {"path_length_m", result.path_length_m},
      {"duration_s", result.duration_s},
      {"tracking_share", figures.tracking_share},
      {"doubtful_share", figures.doubtful_share},
      {"lost_share", figures.lost_share},
      {"first_tracking_s", optional_number(figures.first_tracking_s)},
      {"first_tracking_m", optional_number(figures.first_tracking_m)},
      {"state_changes", figures.state_changes},
      {"searches", result.searches.size()},
      {"searches_of_whole_map", whole_map},
      {"probability_mean", figures.probability_mean},
      {"explained_mean", figures.explained_mean},
      {"violations_mean", figures.violations_mean},
      {"unexpected_mean", figures.unexpected_mean},
      {"sigma_xy_rms_m", figures.sigma_xy_rms_m},
      {"sigma_yaw_rms_rad", figures.sigma_yaw_rms_rad},
      {"last_pose", result.estimates.empty() ? Json() : pose_json(result.estimates.back())},
      {"wall_time_s", run.wall_time_s},
      {"cpu_time_s", run.cpu_time_s},
      {"search_wall_s", result.search_s},
      {"filter_wall_s", result.filter_s},
      {"realtime_factor", ratio_or_zero(result.duration_s, run.wall_time_s)},
      {"scans_per_s", ratio_or_zero(static_cast<double>(result.scans), run.wall_time_s)},
      {"threads", run.threads},
      {"peak_memory_bytes", run.peak_memory_bytes},
      {"map_free_area_m2", info.map_free_area_m2},
      {"map_width_m", occupancy.frame().columns * occupancy.frame().resolution},
      {"map_height_m", occupancy.frame().rows * occupancy.frame().resolution},
      {"map_resolution_m", occupancy.frame().resolution},
      {"map_memory_bytes", info.map_memory_bytes},
      {"warnings", result.warnings},
  };
}

void list_figures(const Json& value, const std::string& prefix,
                  std::vector<SummaryFigure>& figures) {
  for (const auto& [name, child] : value.items()) {
    const std::string key = prefix + name;
    if (child.is_object()) list_figures(child, key + ".", figures);
    if (child.is_null()) figures.push_back({.key = key});
    if (!child.is_number()) continue;
    const auto number = child.get<double>();
    figures.push_back({key, std::isfinite(number) ? std::optional(number) : std::nullopt});
  }
}

}  // namespace

std::string format_summary(const LocalizationResult& result, const Grid<std::int8_t>& occupancy,
                           const LocalizationRunInfo& info) {
  // Paths need not be UTF-8; JSON must.
  return summary_json(result, occupancy, info).dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

std::vector<SummaryFigure> summary_figures(const LocalizationResult& result,
                                           const Grid<std::int8_t>& occupancy,
                                           const LocalizationRunInfo& info) {
  std::vector<SummaryFigure> figures;
  list_figures(summary_json(result, occupancy, info), "", figures);
  return figures;
}

}  // namespace loopstone
