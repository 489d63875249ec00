#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// Hangs reflectors where a robot on its route through the world sees them: strips of 10 cm on
/// walls, and round ones where the world has columns of 10 cm or more (they are wrapped) and, each
/// fourth, posts of 8 cm that stand before a wall. They are numbered from 1. Each goes where the
/// most of the route sees fewer than five, so that with enough of them five are in view everywhere;
/// none is nearer than 1 m to another. There may be fewer than asked for, when no place is left.
///
/// The same arguments give the same world; another seed other places.
/// \param robot_radius_m  as for drive_route
/// Cost: the route, and about 1 us for each of (places on walls) x (places of the route within 10
/// m). Throws UsageError as drive_route does.
[[nodiscard]] World with_reflectors(World world, double robot_radius_m, const DriveOptions& drive,
                                    int count, std::uint64_t seed);

/// The world's reflectors as landmarks whose places are known.
[[nodiscard]] std::vector<MappedLandmark> landmarks_of(const World& world);

}  // namespace loopstone
