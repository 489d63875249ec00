#include "simulated_folder.hpp"

#include <cmath>
#include <initializer_list>
#include <optional>
#include <system_error>
#include <utility>

#include "floor_files.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/formats/ucsd_pictures.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/version.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

namespace fs = std::filesystem;

namespace {

nlohmann::ordered_json to_json(const SimulationOptions& options) {
  SimulationOptions copy = options;
  auto json = nlohmann::ordered_json::object();
  for (const OptionEntry& entry : list_options(copy)) {
    auto* at = &json;
    std::size_t from = 0;
    for (std::size_t dot = entry.key.find('.'); dot != entry.key.npos;
         dot = entry.key.find('.', from)) {
      at = &(*at)[entry.key.substr(from, dot - from)];
      from = dot + 1;
    }
    std::visit([&](const auto& value) { (*at)[entry.key.substr(from)] = *value; }, entry.value);
  }
  return json;
}

nlohmann::ordered_json to_json(const RobotModel& robot) {
  const Pose2 robot_T_lidar =
      robot.lidars.empty() ? LidarMount{}.robot_T_lidar : robot.lidars.front().robot_T_lidar;
  return {{"name", robot.name},
          {"footprint_radius_m", robot.footprint_radius_m},
          {"metres_per_count", robot.wheels.metres_per_count},
          {"track_width_m", robot.wheels.track_width_m},
          {"robot_T_lidar",
           {{"x_m", robot_T_lidar.x}, {"y_m", robot_T_lidar.y}, {"yaw_rad", robot_T_lidar.yaw}}}};
}

/// What was worse than in a clean simulation: the effects, what was drawn for them, and what they
/// spoilt when, in seconds since the log's start and as stamps of the log.
nlohmann::ordered_json to_json(const RealismRecord& record, const SimulationOptions& options) {
  nlohmann::ordered_json json;
  json["effects"] = realism_names(options.realism);
  json["drawn"] = nlohmann::ordered_json::object();
  for (const RealismFact& fact : record.facts) json["drawn"][fact.effect][fact.name] = fact.value;
  json["spoils"] = nlohmann::ordered_json::array();
  for (const RealismSpoil& spoil : record.spoils) {
    json["spoils"].push_back({{"effect", spoil.effect},
                              {"from_s", spoil.from_s},
                              {"to_s", spoil.to_s},
                              {"from_stamp_s", options.start_s + spoil.from_s},
                              {"to_stamp_s", options.start_s + spoil.to_s}});
  }
  return json;
}

/// The camera as it truly was, which the robot's file does not say.
nlohmann::ordered_json to_json(const CameraModel& camera, const SimulatedCamera& options) {
  const Eigen::Vector3d angles = to_roll_pitch_yaw(camera.robot_T_camera);
  const Eigen::Vector3d& position = camera.robot_T_camera.translation;
  return {{"robot_T_camera",
           {{"x_m", position.x()},
            {"y_m", position.y()},
            {"z_m", position.z()},
            {"roll_rad", angles.x()},
            {"pitch_rad", angles.y()},
            {"yaw_rad", angles.z()}}},
          {"clock_offset_s", options.clock_offset_s}};
}

/// Where pictures are files until a recording has taken them in.
struct PassingFolder {
  explicit PassingFolder(fs::path where) : path(std::move(where)) { fs::remove_all(path); }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  ~PassingFolder() {
    std::error_code error;
    fs::remove_all(path, error);
  }

  fs::path path;
};

}  // namespace

LogTarget SimulatedFolder::log() const {
  const bool is_file = format->place == LogPlace::kFile;
  return {format, (is_file ? path / log_name() : path).string()};
}

std::string SimulatedFolder::log_name() const {
  if (format->place == LogPlace::kFolder) return ".";
  return "log" + std::string(format->endings.front());
}

SimulatedDrive write_drive(const SimulatedFolder& folder, const World& world,
                           const RobotModel& robot, const SimulationOptions& options,
                           std::uint64_t seed, const AppContext& context) {
  const auto writer = create_log(folder.log(), robot);
  ProgressDisplay display(context);
  SimulatedDrive simulated;
  SimulationSink sink;
  sink.message = [&](const SensorMessage& message) { writer->write(message); };
  std::optional<PassingFolder> passing;
  if (folder.has_pictures && !folder.format->has_picture_files) {
    passing.emplace(folder.path / "pictures.unfinished");
  }
  UcsdPictures pictures{(passing ? passing->path : folder.path).string()};
  pictures.holds_disparity = robot.camera.encoding.kind == DepthKind::kDisparity;
  if (folder.has_pictures) {
    pictures.make_folders();
    sink.frame = [&](const SimulatedFrame& frame) -> RgbdFrame {
      pictures.write_depth(frame.index, frame.depth);
      pictures.write_colour(frame.index, frame.colour);
      return {.stamp = frame.depth_stamp,
              .colour_stamp = frame.colour_stamp,
              .colour_path = pictures.colour_path(frame.index),
              .depth_path = pictures.depth_path(frame.index)};
    };
  }
  sink.truth = [&](const StampedPose2& pose) { simulated.truth.append(pose.stamp, pose.pose); };
  std::int64_t scans = 0;
  sink.progress = [&](double done_s, double total_s) {
    Progress progress{"simulating", std::llround(done_s), std::llround(total_s), ++scans};
    progress.recorded_s = done_s;
    return display.show(progress);
  };
  simulated.summary = simulate(world, robot, options, seed, sink);
  writer->finish();
  simulated.notes = writer->notes();
  ProgressDisplay::clear_line();
  return simulated;
}

void write_truth(const SimulatedFolder& folder, const World& world, const Trajectory& truth) {
  write_tum((folder.path / "truth.tum").string(), truth);
  const CellStates map = true_map(world);
  write_ros_map((folder.path / "map.yaml").string(), map);
  if (world.floor) write_floor(folder.path, *world.floor, map.frame());
}

void write_description(const SimulatedFolder& folder, nlohmann::ordered_json result,
                       const RobotModel& robot, const SimulationOptions& options,
                       const RealismRecord& record, const std::optional<std::string>& floor) {
  result["log"] = folder.log_name();
  result["robot"] = to_json(robot);
  if (folder.has_pictures) {
    result["floor"] = floor.value_or("mixed");
    result["camera"] = to_json(true_camera(robot.camera, options.camera), options.camera);
  }
  result["options"] = to_json(options);
  if (realism_names(options.realism).empty()) {
    result["options"].erase("realism");
  } else {
    result["realism"] = to_json(record, options);
  }
  result["version"] = std::string(kVersion);
  write_text_file((folder.path / "world.json").string(), result.dump(2) + "\n");
}

void remove_simulation(const fs::path& folder) {
  std::error_code error;
  if (!fs::remove(folder / "world.json", error)) return;
  for (const char* const name : {"truth.tum", "map.yaml", "map.pgm", "floor.png", "floor.yaml",
                                 "floor_letters.csv", "landmarks.csv"}) {
    fs::remove(folder / name, error);
  }
  for (const LogFormat& format : log_formats()) {
    if (!format.can_be_written()) continue;
    const LogParts parts = log_parts(SimulatedFolder{folder, &format}.log());
    for (const std::string& file : parts.files) fs::remove(file, error);
    for (const std::string& pictures : parts.folders) fs::remove_all(pictures, error);
  }
}

}  // namespace loopstone::app
