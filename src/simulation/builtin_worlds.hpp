#pragma once

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

// Each fills an empty world.
void build_office(World& world, Rng rng);
void build_campus(World& world, Rng rng);
void build_corridor(World& world, Rng rng);
void build_rooms(World& world, Rng rng);
void build_warehouse(World& world, Rng rng);

}  // namespace loopstone
