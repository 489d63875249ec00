#include "report/map_messages.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>

#include "formats/topic_names.hpp"
#include "report/canvas.hpp"

namespace loopstone {
namespace {

/// Above the map, so that both are seen.
constexpr double kMarkerHeightM = 0.05;

msg::ColorRGBA to_message(const Colour& colour) {
  return {.r = static_cast<float>(colour.red),
          .g = static_cast<float>(colour.green),
          .b = static_cast<float>(colour.blue),
          .a = static_cast<float>(colour.alpha)};
}

msg::Point point_at(const Eigen::Vector2d& position) {
  return {.x = position.x(), .y = position.y(), .z = kMarkerHeightM};
}

msg::Marker marker(std::string name, std::int32_t type, Stamp stamp, unsigned rgb) {
  return {.header = {stamp, kMapFrame},
          .ns = std::move(name),
          .type = type,
          .color = to_message(hex_colour(rgb))};
}

unsigned colour_of(ClosureState state) {
  switch (state) {
    case ClosureState::kStanding:
      return 0x00875a;
    case ClosureState::kWaiting:
      return 0xe69f00;
    case ClosureState::kRejected:
      return 0xb0004e;
    case ClosureState::kRevoked:
      break;
  }
  return 0x7b2fbe;
}

std::uint8_t level_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return msg::DiagnosticStatus::kOk;
    case Verdict::kBad:
      return msg::DiagnosticStatus::kError;
    case Verdict::kDoubtful:
    case Verdict::kUnknown:  // that nothing is known is no good news
      break;
  }
  return msg::DiagnosticStatus::kWarn;
}

std::uint8_t level_of(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracked:
    case TrackingStatus::kDegenerate:
      return msg::DiagnosticStatus::kOk;
    case TrackingStatus::kBridged:
      return msg::DiagnosticStatus::kWarn;
    case TrackingStatus::kLost:
      break;
  }
  return msg::DiagnosticStatus::kError;
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

std::string value_of(const QualityMeasure& measure) {
  return measure.verdict == Verdict::kUnknown ? std::string(to_string(Verdict::kUnknown))
                                              : number(measure.value);
}

msg::DiagnosticStatus status(const std::string& of, std::uint8_t level, std::string message) {
  return {.level = level, .name = "loopstone: " + of, .message = std::move(message)};
}

msg::DiagnosticStatus diagnostic_of(const OdometryEpisode& episode) {
  const std::string part =
      episode.part == OdometryPart::kWhole ? "" : " " + std::string(to_string(episode.part));
  const std::string fault(to_string(episode.fault));
  auto told = episode.over
                  ? status("odometry" + part, msg::DiagnosticStatus::kOk, "no longer " + fault)
                  : status("odometry" + part, msg::DiagnosticStatus::kWarn, fault + ": not used");
  told.values = {{"fault", fault},
                 {"from_s", fmt::format("{:.3f}", episode.from.seconds())},
                 {"ratio", number(episode.ratio)},
                 {"lag_s", number(episode.lag_s)}};
  return told;
}

msg::DiagnosticStatus diagnostic_of(const LaserFaultChanged& change) {
  const LaserEpisode& episode = change.episode;
  const std::string fault(to_string(episode.fault));
  auto told = change.over ? status(laser_frame(episode.lidar), msg::DiagnosticStatus::kOk,
                                   "no longer " + fault)
                          : status(laser_frame(episode.lidar), msg::DiagnosticStatus::kError,
                                   fault + (episode.fault == LaserFault::kCovered
                                                ? " in part: what is nearest is not used"
                                                : ": its scans are not used"));
  told.values = {{"fault", fault},
                 {"from_s", fmt::format("{:.3f}", episode.from.seconds())},
                 {"scans", std::to_string(episode.scans)}};
  return told;
}

msg::DiagnosticStatus diagnostic_of(const PathBreak& gap) {
  auto told = status(
      "path", msg::DiagnosticStatus::kWarn,
      fmt::format("the laser did not hold the pose for {:.1f} s", (gap.to - gap.from).seconds()));
  told.values = {{"cause", std::string(to_string(gap.cause))},
                 {"bridged_by", std::string(to_string(gap.bridge))},
                 {"from_s", fmt::format("{:.3f}", gap.from.seconds())},
                 {"to_s", fmt::format("{:.3f}", gap.to.seconds())},
                 {"odometry_m", number(gap.odometry_m)}};
  return told;
}

msg::DiagnosticStatus verdict_status(const MapResult& result) {
  const MapStatistics& s = result.statistics;
  const MapVerdict& verdict = result.verdict;
  auto told = status("map", level_of(verdict.overall),
                     verdict.sentence.empty() ? "not judged" : verdict.sentence);
  told.values = {{"verdict", std::string(to_string(verdict.overall))},
                 {"complete", result.complete ? "true" : "false"},
                 {"scans", std::to_string(s.scans)},
                 {"path_length_m", number(s.path_length_m)},
                 {"submaps", std::to_string(s.submaps)},
                 {"loop_closures_accepted", std::to_string(s.loop_closures_accepted)},
                 {"loop_closures_rejected", std::to_string(s.loop_closures_rejected)}};
  for (const QualityMeasure& measure : verdict.measures) {
    told.values.push_back({measure.name, value_of(measure)});
  }
  return told;
}

}  // namespace

msg::OccupancyGrid to_message(const CellStates& cells, Stamp stamp) {
  const GridFrame& frame = cells.frame();
  msg::OccupancyGrid grid{.header = {stamp, kMapFrame}};
  grid.info = {.map_load_time = stamp,
               .resolution = static_cast<float>(frame.resolution),
               .width = static_cast<std::uint32_t>(frame.columns),
               .height = static_cast<std::uint32_t>(frame.rows),
               .origin = {.position = {.x = frame.origin.x(), .y = frame.origin.y()}}};
  grid.data = cells.cells();
  return grid;
}

msg::Path path_message(const std::vector<StampedPose2>& poses, Stamp stamp) {
  msg::Path path{.header = {stamp, kMapFrame}};
  path.poses.reserve(poses.size());
  for (const StampedPose2& pose : poses) {
    path.poses.push_back({.header = {pose.stamp, kMapFrame}, .pose = to_message(pose.pose)});
  }
  return path;
}

msg::MarkerArray submap_markers(const std::vector<Pose2>& map_T_submap, Stamp stamp) {
  constexpr unsigned kOrange = 0xd55e00;
  constexpr double kPointM = 0.2;
  constexpr double kTextM = 0.4;
  msg::MarkerArray array;
  msg::Marker origins = marker("origins", msg::Marker::kPoints, stamp, kOrange);
  origins.scale = {.x = kPointM, .y = kPointM};
  if (map_T_submap.empty()) origins.action = msg::Marker::kDelete;
  for (std::size_t i = 0; i < map_T_submap.size(); ++i) {
    const Eigen::Vector2d position = map_T_submap[i].translation();
    origins.points.push_back(point_at(position));
    msg::Marker id = marker("ids", msg::Marker::kText, stamp, kOrange);
    id.id = static_cast<std::int32_t>(i);
    id.scale.z = kTextM;
    id.pose.position = {.x = position.x(), .y = position.y(), .z = kTextM};
    id.text = std::to_string(i);
    array.markers.push_back(std::move(id));
  }
  array.markers.push_back(std::move(origins));
  return array;
}

std::vector<ClosureLine> closure_lines(const MapResult& result) {
  const auto position_of = [&](NodeId node) -> Eigen::Vector2d {
    const auto index = static_cast<std::size_t>(node.index);
    if (node.index < 0 || index >= result.node_stamps.size()) return Eigen::Vector2d::Zero();
    return result.trajectory.at_clamped(result.node_stamps[index]).value_or(Pose2{}).translation();
  };
  std::vector<ClosureLine> lines;
  for (const LoopClosure& closure : result.loop_closures)
    lines.push_back({closure.state, position_of(closure.from), position_of(closure.to)});
  return lines;
}

msg::MarkerArray closure_markers(const std::vector<ClosureLine>& lines, Stamp stamp) {
  constexpr double kStandingM = 0.05;
  constexpr double kOtherM = 0.02;
  msg::MarkerArray array;
  for (const auto& [state, name] : words_of(ClosureState{})) {
    msg::Marker list = marker(std::string(name), msg::Marker::kLineList, stamp, colour_of(state));
    list.scale.x = state == ClosureState::kStanding ? kStandingM : kOtherM;
    for (const ClosureLine& line : lines) {
      if (line.state != state) continue;
      list.points.push_back(point_at(line.from));
      list.points.push_back(point_at(line.to));
    }
    if (list.points.empty()) list.action = msg::Marker::kDelete;  // viewers complain of no points
    array.markers.push_back(std::move(list));
  }
  return array;
}

std::optional<msg::DiagnosticStatus> diagnostic_of(const MapEvent& event) {
  return std::visit(
      [](const auto& one) -> std::optional<msg::DiagnosticStatus> {
        using Event = std::remove_cvref_t<decltype(one)>;
        if constexpr (std::is_same_v<Event, OdometryFaultChanged>)
          return diagnostic_of(one.episode);
        else if constexpr (std::is_same_v<Event, LaserFaultChanged>)
          return diagnostic_of(one);
        else if constexpr (std::is_same_v<Event, PathBroken>)
          return diagnostic_of(one.gap);
        else
          return std::nullopt;
      },
      event);
}

msg::DiagnosticStatus diagnostic_of(const MapUpdate& update) {
  return status("tracking", level_of(update.status), std::string(to_string(update.status)));
}

std::vector<msg::DiagnosticStatus> diagnostics_of(const MapResult& result) {
  std::vector<msg::DiagnosticStatus> told{verdict_status(result)};
  for (const QualityMeasure& measure : result.verdict.measures) {
    told.push_back(status("map " + measure.name, level_of(measure.verdict), measure.sentence));
    told.back().values = {{"verdict", std::string(to_string(measure.verdict))},
                          {measure.name, value_of(measure)}};
  }
  const std::size_t warnings = result.warnings.size();
  told.push_back(status("warnings",
                        warnings == 0 ? msg::DiagnosticStatus::kOk : msg::DiagnosticStatus::kWarn,
                        warnings == 0 ? "none" : fmt::format("{}", warnings)));
  for (std::size_t i = 0; i < warnings; ++i) {
    told.back().values.push_back({std::to_string(i + 1), result.warnings[i]});
  }
  return told;
}

}  // namespace loopstone
