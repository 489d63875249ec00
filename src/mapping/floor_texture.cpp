#include "loopstone/mapping/floor_texture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "mapping/cloud_gatherer.hpp"
#include "mapping/smooth_pose.hpp"
#include "mapping/texture_finish.hpp"
#include "mapping/texture_mapper.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kFloorFrames = 40;

/// The frames that can be used: with depth and colour, spread evenly when only so many are wanted.
std::vector<RgbdFrame> complete_frames(const RgbdSource& source) {
  std::vector<RgbdFrame> frames;
  for (const RgbdFrame& frame : source.frames) {
    if (!frame.colour_path.empty() && !frame.depth_path.empty()) frames.push_back(frame);
  }
  return frames;
}

FloorEstimate estimate_floor(const RgbdSource& source, const std::vector<RgbdFrame>& frames,
                             const CameraModel& camera, Threads threads) {
  const std::size_t count = std::min(kFloorFrames, frames.size());
  std::vector<InverseDepthImage> depths(count);
  parallel_for(count, threads, [&](std::size_t i) {
    RgbdFrame frame = frames[i * frames.size() / count];
    frame.colour_path.clear();
    try {
      depths[i] = source.load(frame).depth;
    } catch (const DataError&) {  // counted when the frame's turn comes
    }
  });
  FloorPlaneEstimator estimator(camera);
  for (const InverseDepthImage& depth : depths) estimator.add(depth);
  return estimator.estimate();
}

/// A frame whose turn it is.
struct Job {
  const RgbdFrame* frame = nullptr;
  FramePose pose{};
  RgbdImages images{};
  std::string problem{};  ///< why it could not be loaded
};

class FrameChooser {
 public:
  FrameChooser(const Trajectory& trajectory, const TextureOptions& options, double camera_late_s,
               TextureStatistics& statistics)
      : trajectory_(trajectory),
        options_(options),
        late_(Duration::from_seconds(camera_late_s)),
        statistics_(statistics) {}

  /// Where the frame was taken, if it is worth using.
  [[nodiscard]] std::optional<FramePose> choose(const RgbdFrame& frame) {
    const Stamp depth_stamp = frame.stamp - late_;
    const Stamp colour_stamp = frame.colour_stamp - late_;
    const auto depth_pose = smooth_pose_at(trajectory_, depth_stamp);
    const auto colour_pose = smooth_pose_at(trajectory_, colour_stamp);
    if (!depth_pose || !colour_pose) {
      ++statistics_.frames_without_pose;
      return {};
    }
    const Pose2 camera_pose = pose_of_camera(frame, *colour_pose);
    if (last_) {
      const Pose2 step = last_->inverse() * camera_pose;
      if (step.translation().norm() < options_.min_travel_m &&
          std::abs(step.yaw) < options_.min_turn_rad) {
        ++statistics_.frames_still;
        return {};
      }
    }
    last_ = camera_pose;
    FramePose pose{*depth_pose, *colour_pose};
    constexpr double kSpan_s = 0.05;
    const auto before = trajectory_.at_clamped(colour_stamp - Duration::from_seconds(kSpan_s));
    const auto after = trajectory_.at_clamped(colour_stamp + Duration::from_seconds(kSpan_s));
    const Pose2 motion = before->inverse() * *after;
    pose.speed_m_s = motion.translation().norm() / (2.0 * kSpan_s);
    pose.yaw_rate_rad_s = motion.yaw / (2.0 * kSpan_s);
    return pose;
  }

 private:
  /// The robot's where the camera is fixed to it.
  static Pose2 pose_of_camera(const RgbdFrame& frame, const Pose2& map_T_robot) {
    if (!frame.robot_T_camera) return map_T_robot;
    const Eigen::Vector3d& place = frame.robot_T_camera->translation;
    return map_T_robot * Pose2{place.x(), place.y(), to_roll_pitch_yaw(*frame.robot_T_camera).z()};
  }

  const Trajectory& trajectory_;
  const TextureOptions& options_;
  Duration late_;
  TextureStatistics& statistics_;
  std::optional<Pose2> last_{};
};

/// What frames are gathered into.
struct Gatherers {
  CameraModel camera;
  bool correct_mount = true;
  TextureMapper texture;
  std::optional<CloudGatherer> cloud{};

  /// Where the camera of a frame really sat, by the floor that it sees. False: it sees none.
  bool look_from(const Pose3& robot_T_camera, const InverseDepthImage& depth) {
    camera.robot_T_camera = robot_T_camera;
    if (robot_T_camera.translation.z() <= 0.0) return false;
    FloorPlaneEstimator estimator(camera);
    estimator.add(depth);
    FloorEstimate floor = estimator.estimate();
    if (floor.status != FloorStatus::kEstimated) return false;
    if (correct_mount) {
      camera.robot_T_camera = floor.robot_T_camera;
    } else {
      floor.plane = floor_plane_of(robot_T_camera);
    }
    texture.look_from(camera, floor);
    if (cloud) cloud->look_from(camera.robot_T_camera);
    return true;
  }

  TextureMapper::Use add(const Job& job) {
    const auto& mount = job.frame->robot_T_camera;
    if (mount && !look_from(*mount, job.images.depth)) return TextureMapper::Use::kTilted;
    const TextureMapper::Use use = texture.add(job.images, job.pose);
    if (cloud && use == TextureMapper::Use::kUsed) cloud->add(job.images, job.pose);
    return use;
  }
};

void use_frame(const Job& job, Gatherers& gatherers, FloorTexture& texture) {
  TextureStatistics& statistics = texture.statistics;
  if (!job.problem.empty()) {
    constexpr std::int64_t kMostWarnings = 3;
    if (++statistics.frames_unreadable <= kMostWarnings) texture.warnings.push_back(job.problem);
  } else if (gatherers.add(job) == TextureMapper::Use::kTilted) {
    ++statistics.frames_tilted;
  } else {
    ++statistics.frames_used;
  }
}

/// Loads the next frames while the ones before are put on the map.
void map_frames(const RgbdSource& source, const std::vector<RgbdFrame>& frames,
                const Trajectory& trajectory, const TextureOptions& options, Threads threads,
                const ProgressCallback& progress, Gatherers& gatherers, FloorTexture& texture) {
  FrameChooser chooser(
      trajectory, options,
      options.correct_clock && texture.clock.is_significant() ? texture.clock.late_s : 0.0,
      texture.statistics);
  const std::size_t batch = 2 * static_cast<std::size_t>(threads.resolved());
  std::vector<Job> loaded;
  std::size_t next = 0;
  while (true) {
    std::vector<Job> loading;
    while (next < frames.size() && loading.size() < batch) {
      const RgbdFrame& frame = frames[next++];
      if (const auto pose = chooser.choose(frame)) loading.push_back({&frame, *pose, {}, {}});
    }
    if (loading.empty() && loaded.empty()) return;
    parallel_for(loading.size() + 1, threads, [&](std::size_t i) {
      if (i == 0) {
        for (const Job& job : loaded) use_frame(job, gatherers, texture);
        return;
      }
      Job& job = loading[i - 1];
      try {
        job.images = source.load(*job.frame);
      } catch (const DataError& error) {
        job.problem = error.what();
      }
    });
    loaded = std::move(loading);
    if (progress && !progress({"colouring the floor", static_cast<std::int64_t>(next),
                               static_cast<std::int64_t>(frames.size())})) {
      texture.complete = false;
      return;
    }
  }
}

/// What a user should know, in plain words.
void add_warnings(const TextureOptions& options, FloorTexture& texture) {
  std::vector<std::string> warnings;
  const FloorEstimate& floor = texture.floor;
  constexpr double kWorthSaying_rad = radians(0.3);
  constexpr double kWorthSaying_m = 0.01;
  if (floor.status == FloorStatus::kNotSeen && texture.statistics.frames > 0) {
    warnings.emplace_back(
        "the camera hardly sees the floor where its mount in the robot file says; the texture may "
        "be "
        "empty or wrong");
  } else if (std::abs(floor.pitch_error_rad) > kWorthSaying_rad ||
             std::abs(floor.roll_error_rad) > kWorthSaying_rad ||
             std::abs(floor.height_error_m) > kWorthSaying_m) {
    warnings.push_back(
        fmt::format("the camera's mount differs from the robot file: pitch by {:+.2f} deg, roll by "
                    "{:+.2f} deg, "
                    "height by {:+.1f} cm{}",
                    degrees(floor.pitch_error_rad), degrees(floor.roll_error_rad),
                    100.0 * floor.height_error_m, options.correct_mount ? "; corrected" : ""));
  }
  const CameraClock& clock = texture.clock;
  constexpr double kClockWorthSaying_s = 0.01;
  if (clock.is_significant() && std::abs(clock.late_s) > kClockWorthSaying_s) {
    warnings.push_back(fmt::format(
        "the camera's stamps are {:.0f} ms too {} (+- {:.1f} ms); corrected",
        std::abs(1e3 * clock.late_s), clock.late_s > 0.0 ? "late" : "early", 1e3 * clock.sigma_s));
  }
  const TextureStatistics& s = texture.statistics;
  if (s.frames_tilted * 20 > s.frames) {
    warnings.push_back(fmt::format(
        "{} of {} frames see a floor that is tilted against the others', or none; not used",
        s.frames_tilted, s.frames));
  }
  if (s.frames_without_pose * 20 > s.frames) {
    warnings.push_back(fmt::format("{} of {} frames were taken when the trajectory has no pose",
                                   s.frames_without_pose, s.frames));
  }
  texture.warnings.insert(texture.warnings.begin(), warnings.begin(), warnings.end());
}

}  // namespace

FloorTexture map_floor_texture(const RgbdSource& source, const Trajectory& trajectory,
                               const CameraModel& given_camera, const TextureOptions& options,
                               Threads threads, const ProgressCallback& progress) {
  FloorTexture texture;
  const std::vector<RgbdFrame> frames = complete_frames(source);
  texture.statistics.frames = static_cast<std::int64_t>(frames.size());

  const bool mount_moves = std::ranges::any_of(
      frames, [](const RgbdFrame& frame) { return frame.robot_T_camera.has_value(); });
  if (mount_moves) {
    texture.floor.status = FloorStatus::kByFrame;
    texture.floor.robot_T_camera = given_camera.robot_T_camera;
  } else {
    texture.floor = estimate_floor(source, frames, given_camera, threads);
  }
  CameraModel camera = given_camera;
  FloorEstimate used_floor = texture.floor;
  if (options.correct_mount && !mount_moves) {
    camera.robot_T_camera = texture.floor.robot_T_camera;
  } else {
    used_floor.plane = floor_plane_of(camera.robot_T_camera);
  }

  if (options.correct_clock && !mount_moves) {
    texture.clock = estimate_camera_clock({frames, source.load}, trajectory, camera, threads);
  }

  Gatherers gatherers{camera, options.correct_mount, TextureMapper(camera, used_floor, options)};
  if (options.cloud_cube_m > 0.0) {
    gatherers.cloud.emplace(camera, used_floor.noise_per_m, options.cloud_cube_m);
  }
  map_frames(source, frames, trajectory, options, threads, progress, gatherers, texture);
  const TextureMapper& mapper = gatherers.texture;

  const TextureMapper::Brightness brightness = mapper.brightness();
  texture.statistics.gain_spread = brightness.spread;
  texture.statistics.memory_bytes = static_cast<std::int64_t>(mapper.cells().memory_bytes());
  finish_texture(mapper.cells(), options, brightness.mean, texture);
  if (gatherers.cloud) texture.cloud = gatherers.cloud->points();
  add_warnings(options, texture);
  return texture;
}

}  // namespace loopstone
