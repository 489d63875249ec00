#include "floor_run.hpp"

#include <fmt/format.h>

#include <variant>

#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone::app {

void CameraFrames::take(const SensorMessage& message) {
  const auto* frame = std::get_if<RgbdFrame>(&message);
  if (frame == nullptr) return;
  frames_.push_back(*frame);
  if (!frame->colour_path.empty() && !frame->depth_path.empty()) ++complete_;
}

void CameraFrames::take_pictures(const LogReader& log) {
  pictures_ = log.pictures();
  fault_ = log.camera_fault();
}

void gather_cloud(TextureOptions& options) {
  constexpr double kCube_m = 0.02;
  if (options.cloud_cube_m == 0.0) options.cloud_cube_m = kCube_m;
}

FloorTexture colour_floor(const CameraFrames& camera, const Trajectory& trajectory,
                          const RobotModel& robot, const TextureOptions& options,
                          const AppContext& context, ProgressDisplay& display) {
  const RgbdLoader loader(robot.camera, camera.pictures());
  const RgbdSource source{camera.frames(),
                          [&](const RgbdFrame& frame) { return loader.load(frame); }};
  FloorTexture texture = map_floor_texture(source, trajectory, robot.camera, options,
                                           context.threads(), display.callback());
  ProgressDisplay::clear_line();
  for (const std::string& warning : texture.warnings) context.warn(warning);
  return texture;
}

void add_texture_rows(const FloorTexture& texture, Result& table) {
  const TextureStatistics& s = texture.statistics;
  table.add("floor_seen_m2", "floor seen in colour", s.seen_area_m2, "m2", 1);
  table.add_row("camera frames", fmt::format("{} used of {}", s.frames_used, s.frames));
  if (texture.floor.status == FloorStatus::kEstimated) {
    table.add_row(
        "camera's mount",
        fmt::format("pitch {:+.2f} deg, roll {:+.2f} deg, height {:+.1f} cm against the "
                    "robot file",
                    degrees(texture.floor.pitch_error_rad), degrees(texture.floor.roll_error_rad),
                    100.0 * texture.floor.height_error_m));
  }
  if (texture.clock.status == ClockStatus::kEstimated) {
    table.add_row("camera's clock",
                  fmt::format("{:+.1f} ms late (+- {:.1f})", 1e3 * texture.clock.late_s,
                              1e3 * texture.clock.sigma_s));
  }
}

}  // namespace loopstone::app
