#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/floor_plan.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {

/// People who stand beside the robot's way for some minutes and shift their weight.
class Standers {
 public:
  Standers(const Drive& drive, const SurfaceIndex& surfaces, const RealismStanders& options,
           Rng rng);
  /// Appends two circles a person who is there, map frame.
  void add_legs(double time_s, std::vector<Circle>& legs) const;
  [[nodiscard]] std::size_t count() const { return people_.size(); }

 private:
  struct Stander {
    Pose2 map_T_person;
    double from_s = 0.0;
    double to_s = 0.0;
    double phase_rad = 0.0;
  };
  std::vector<Stander> people_{};
};

}  // namespace loopstone
