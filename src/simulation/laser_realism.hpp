#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "simulation/beam_dropouts.hpp"
#include "simulation/beam_path.hpp"
#include "simulation/company.hpp"
#include "simulation/laser_spoils.hpp"
#include "simulation/mixed_pixels.hpp"
#include "simulation/moved_things.hpp"
#include "simulation/people.hpp"
#include "simulation/range_errors.hpp"
#include "simulation/standers.hpp"
#include "simulation/uneven_floor.hpp"

namespace loopstone {

/// All that makes a laser's scans worse than ideal ones, in the order in which it happens: what a
/// beam meets, what the laser makes of it, what the log then holds. Effects that are off change no
/// bit.
class LaserRealism {
 public:
  /// \param mount     where the robot's file says that the laser sits
  /// \param surfaces  of the world; they and the drive must outlive it
  LaserRealism(const World& world, const Drive& drive, const SurfaceIndex& surfaces,
               const RobotModel& robot, const LidarMount& mount, const Realism& realism,
               std::uint64_t seed);

  /// Where the laser truly sits.
  [[nodiscard]] const Pose2& robot_T_lidar() const { return robot_T_lidar_; }
  /// Appends the legs of all who are there besides `people`.
  void add_people(double time_s, std::vector<Circle>& legs) const;

  /// What the beam meets that the log says points to `angle_rad`.
  [[nodiscard]] BeamEcho meet(double time_s, double angle_rad, double max_range_m,
                              const std::vector<Circle>& people);
  /// The range that the laser measures of it, its usual noise left out.
  [[nodiscard]] double measured(const BeamEcho& met);
  /// What the log holds of a scan that began at that time.
  void spoil(LaserScan& scan, double time_s);

  void note(RealismRecord& record) const;

 private:
  [[nodiscard]] BeamEcho meet_one(const Pose2& map_T_lidar, double angle_rad, double max_range_m,
                                  const SurfaceIndex& surfaces, const FloorTilt& tilt,
                                  const std::vector<Circle>& people) const;

  const Drive& drive_;
  const SurfaceIndex& surfaces_;
  Realism realism_;
  Pose2 robot_T_lidar_;
  double height_m_;
  BeamPath path_;
  Company company_;
  std::unique_ptr<const Crowd> walkers_{};
  std::optional<Standers> standers_{};
  std::optional<MovedThings> moved_{};
  std::optional<UnevenFloor> floor_{};
  std::optional<MixedPixels> mixed_{};
  std::optional<RangeErrors> range_errors_{};
  std::optional<BeamDropouts> dropouts_{};
  std::optional<BlockedLaser> blocked_{};
  std::optional<DirtyWindow> dirty_{};
};

}  // namespace loopstone
