#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_options.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Where the robot is believed to be at the first scan. Nothing: anywhere on the map.
struct InitialPose {
  Pose2 map_T_robot;
  double sigma_m = 0.5;     ///< standard deviation of x and of y
  double sigma_rad = 0.26;  ///< of the heading
};

/// Follows a robot on a known map.
///
///   const LocalizationMap map(read_ros_map("map.yaml"));
///   Localizer localizer(map, robot, options, {}, seed, threads);          // from nowhere
///   while (auto message = log.next()) {
///     localizer.add(*message);
///     while (const auto estimate = localizer.next_update()) drive(estimate->map_T_robot);
///   }
///   LocalizationResult result = localizer.finish();
///
/// The result is the same bytes for any number of threads; the seed decides the particles.
class Localizer {
 public:
  /// Throws OptionsError with everything that is wrong with the options.
  Localizer(const LocalizationMap& map, const RobotModel& robot, const LocalizationOptions& options,
            const std::optional<InitialPose>& initial, std::uint64_t seed, Threads threads = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Messages may come live, as Mapper::add() takes them: a scan waits for odometry of its time, at
  /// most 0.25 s; one that is not newer than the last is left out.
  void add(const SensorMessage& message);

  /// Somebody says where the robot is at the next scan: what was believed is forgotten. Its
  /// odometry and the estimates so far go on.
  void restart_at(const InitialPose& initial);

  /// The oldest estimate that was not handed out yet: one a scan, in their order, from the first
  /// pose on. All of them are in the result too.
  [[nodiscard]] std::optional<LocalizationEstimate> next_update();

  /// What it believes at the newest scan: map_T_robot of each particle. None before the first pose.
  [[nodiscard]] std::vector<Pose2> particles() const;

  /// Ends the recording. Call once.
  [[nodiscard]] LocalizationResult finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
