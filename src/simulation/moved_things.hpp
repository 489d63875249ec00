#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// A world in which doors are opened and shut and chairs are moved between one state and the next.
/// Walls stay, and nothing is moved into the robot's way. Surfaces keep their numbers.
class MovedThings {
 public:
  /// \param footprint_m  radius of the robot that drives
  MovedThings(const World& world, const Drive& drive, double footprint_m,
              const RealismMoved& options, Rng rng);

  /// The world of that moment; the first state is the world as it was drawn.
  [[nodiscard]] const SurfaceIndex& surfaces_at(double time_s) const;
  /// How many things stand elsewhere in the last state.
  [[nodiscard]] std::size_t moved() const { return moved_; }

 private:
  double every_s_;
  std::vector<SurfaceIndex> states_{};
  std::size_t moved_ = 0;
};

}  // namespace loopstone
