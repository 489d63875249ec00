#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/floor_plan.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {

/// The way of a drive by its length, what it was carried included, ahead of its start and its end
/// straight on.
class Breadcrumbs {
 public:
  explicit Breadcrumbs(const Drive& drive);
  /// How far it has come [m]; turning in place does not count.
  [[nodiscard]] double way_m(double time_s) const;
  /// Where it is after so much of its way, looking along it.
  [[nodiscard]] Pose2 at_way(double way_m) const;

 private:
  std::vector<Pose2> poses_{};
  std::vector<double> ways_m_{};
};

/// People who keep to the robot: one who follows, one who walks ahead, a ring of them around it. A
/// laser sees their legs.
class Company {
 public:
  /// \param surfaces  nobody stands behind a wall; must outlive it, as the drive
  Company(const Drive& drive, const SurfaceIndex& surfaces, const Realism& realism,
          std::uint64_t seed);

  /// Appends two circles a person, or one where a body is seen; map frame.
  void add_legs(double time_s, std::vector<Circle>& legs) const;
  /// When each kind of them is there.
  void note(RealismRecord& record) const;

 private:
  struct Bystander {
    double bearing_rad = 0.0;
    double distance = 1.0;  ///< share of the ring's radius
    double phase_rad = 0.0;
  };
  /// Steps aside when the robot comes.
  void add_person(const Pose2& robot, Eigen::Vector2d at, double yaw_rad, double walked_m,
                  double body_m, std::vector<Circle>& legs) const;
  void add_walker(const Pose2& robot, double way_m, double aside_m, double phase_rad, double body_m,
                  std::vector<Circle>& legs) const;
  void add_ring(double time_s, const Pose2& robot, std::vector<Circle>& legs) const;

  const Drive& drive_;
  const SurfaceIndex& surfaces_;
  Breadcrumbs crumbs_;
  RealismFollower follower_;
  RealismAhead ahead_;
  RealismCrowd crowd_;
  double follower_phase_rad_ = 0.0;
  double ahead_phase_rad_ = 0.0;
  std::vector<Bystander> ring_{};
};

}  // namespace loopstone
