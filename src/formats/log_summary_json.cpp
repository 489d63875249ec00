#include <nlohmann/json.hpp>

#include "formats/left_out_json.hpp"
#include "loopstone/formats/log_summary.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

Json timing_json(const TimingSummary& timing, Stamp start) {
  return {{"records", timing.records},
          {"rate_hz", timing.rate_hz},
          {"first_s", timing.first.seconds()},
          {"last_s", timing.last.seconds()},
          {"gaps", timing.gaps},
          {"largest_gap_s", timing.largest_gap_s},
          {"largest_gap_after_s", (timing.largest_gap_at - start).seconds()}};
}

Json lidar_json(const LidarSummary& lidar, Stamp start) {
  auto json = timing_json(lidar.timing, start);
  json["lidar"] = lidar.lidar;
  json["layouts"] = Json::array();
  for (const BeamLayout& layout : lidar.layouts) {
    json["layouts"].push_back({{"scans", layout.scans},
                               {"beams", layout.beams},
                               {"angle_min_rad", layout.angle_min_rad},
                               {"angle_increment_rad", layout.angle_increment_rad},
                               {"field_of_view_rad", layout.field_of_view_rad()}});
  }
  json["range_min_m"] = lidar.range_min_m;
  json["range_max_m"] = lidar.range_max_m;
  json["time_increment_s"] = lidar.time_increment_s;
  if (lidar.robot_T_lidar) {
    json["robot_T_lidar"] = {{"x_m", lidar.robot_T_lidar->x},
                             {"y_m", lidar.robot_T_lidar->y},
                             {"yaw_rad", lidar.robot_T_lidar->yaw}};
  }
  json["beams_returns"] = lidar.ranges.returns;
  json["beams_no_return"] = lidar.ranges.no_return;
  json["beams_bad"] = lidar.ranges.bad;
  json["beams_too_near"] = lidar.ranges.too_near;
  json["beams_too_far"] = lidar.ranges.too_far;
  json["range_percentiles_0_5_25_50_75_95_100_m"] = lidar.range_percentiles_m;
  json["range_histogram_octaves"] = lidar.range_histogram;
  json["repeated_scans"] = lidar.repeated_scans;
  return json;
}

Json camera_json(const CameraSummary& camera, Stamp start) {
  auto json = timing_json(camera.frames, start);
  const auto stream = [&](const TimingSummary& timing, const PictureSize& size) {
    auto part = timing_json(timing, start);
    part["width_px"] = size.width_px;
    part["height_px"] = size.height_px;
    return part;
  };
  if (camera.depth.records > 0) json["depth"] = stream(camera.depth, camera.depth_size);
  if (camera.colour.records > 0) json["colour"] = stream(camera.colour, camera.colour_size);
  json["pairs"] = camera.pairs;
  json["median_offset_s"] = camera.median_offset_s;
  json["largest_offset_s"] = camera.largest_offset_s;
  return json;
}

Json topics_json(const LogSummary& summary) {
  auto json = Json::array();
  for (const TopicSummary& topic : summary.topics) {
    json.push_back({{"name", topic.name},
                    {"type", topic.type},
                    {"messages", topic.messages},
                    {"rate_hz", topic.rate_hz},
                    {"largest_gap_s", topic.largest_gap_s},
                    {"frame", topic.frame},
                    {"role", to_string(topic.role)},
                    {"remark", topic.remark}});
  }
  return json;
}

Json findings_json(const LogSummary& summary) {
  auto json = Json::array();
  for (const Finding& finding : summary.findings) {
    json.push_back({{"severity", to_string(finding.severity)}, {"text", finding.text}});
  }
  return json;
}

Json odometry_json(const OdometrySummary& odometry, Stamp start) {
  Json json = timing_json(odometry.timing, start);
  json["path_length_m"] = odometry.path_length_m;
  json["turned_rad"] = odometry.turned_rad;
  json["largest_step_m"] = odometry.largest_step_m;
  json["jumps"] = odometry.jumps;
  return json;
}

Json wheels_json(const WheelSummary& wheels, Stamp start) {
  Json json = timing_json(wheels.timing, start);
  json["travelled_counts"] = wheels.travelled_counts;
  return json;
}

Json imu_json(const ImuSummary& imu, Stamp start) {
  Json json = timing_json(imu.timing, start);
  json["median_acceleration_m_s2"] = imu.median_acceleration_m_s2;
  json["gravity_along_z"] = imu.gravity_along_z;
  json["median_yaw_rate_rad_s"] = imu.median_yaw_rate_rad_s;
  return json;
}

}  // namespace

std::string log_summary_json(const LogSummary& summary, const std::string& log) {
  const Stamp start = summary.first.value_or(Stamp{});
  Json json = {{"log", log},
               {"format", summary.format},
               {"bytes", summary.bytes},
               {"start_s", start.seconds()},
               {"duration_s", summary.duration_s()},
               {"scans", summary.scans()},
               {"records_skipped", summary.left_out.skipped.records},
               {"left_out", to_json(summary.left_out)},
               {"complete", summary.complete},
               {"lidars", Json::array()}};
  for (const LidarSummary& lidar : summary.lidars) {
    json["lidars"].push_back(lidar_json(lidar, start));
  }
  if (summary.odometry) json["odometry"] = odometry_json(*summary.odometry, start);
  if (summary.wheels) json["wheels"] = wheels_json(*summary.wheels, start);
  if (summary.imu) json["imu"] = imu_json(*summary.imu, start);
  if (summary.camera) json["camera"] = camera_json(*summary.camera, start);
  if (!summary.topics.empty()) {
    json["topics"] = topics_json(summary);
    json["choices"] = summary.choices;
  }
  json["findings"] = findings_json(summary);
  json["mappable"] = summary.worst() != Severity::kError;
  json["verdict"] = summary.verdict();
  // Words of a damaged log need not be UTF-8; JSON must.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace loopstone
