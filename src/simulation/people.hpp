#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/floor_plan.hpp"
#include "loopstone/simulation/world.hpp"
#include "simulation/route_planner.hpp"

namespace loopstone {

/// Appends both legs of a person in mid-stride.
/// \param forward   unit length
/// \param walked_m  how far the person has walked: where in the stride
void add_legs_of_person(const Eigen::Vector2d& middle, const Eigen::Vector2d& forward,
                        double walked_m, std::vector<Circle>& legs);

/// People who walk to and fro, each between a few spots, and step back when the robot comes near. A
/// laser sees their legs.
class Crowd {
 public:
  Crowd(const World& world, const Drive& drive, int count, Rng rng);

  /// Two circles a person, map frame.
  [[nodiscard]] std::vector<Circle> legs_at(double time_s) const;

 private:
  struct Person {
    Path path;
    std::vector<double> path_m;   ///< arc length at its points
    std::vector<float> walked_m;  ///< where on the path, at steps of time
  };
  [[nodiscard]] static Eigen::Vector2d on_path(const Person& person, double at_m);
  static void walk(Person& person, const Drive& drive, Rng& rng);

  const Drive& drive_;
  std::vector<Person> people_{};
};

}  // namespace loopstone
