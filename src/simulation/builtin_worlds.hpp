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
void build_loops(World& world, Rng rng);
void build_wings(World& world, Rng rng);
void build_aisles(World& world, Rng rng);
void build_hall(World& world, Rng rng);
void build_outdoors(World& world, Rng rng);

}  // namespace loopstone
