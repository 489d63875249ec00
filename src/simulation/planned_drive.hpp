#pragma once

#include <cstdint>

#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// The robot's drive through the world, as `rolling`, `carried` and `carried_blind` change it. A
/// robot that is set down goes on to the places that it has not seen and passes all returns.
[[nodiscard]] Drive planned_drive(const World& world, double robot_radius_m,
                                  const DriveOptions& options, const Realism& realism,
                                  std::uint64_t seed);

}  // namespace loopstone
