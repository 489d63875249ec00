#pragma once

#include <span>
#include <vector>

#include "slam/surface_patches.hpp"

namespace loopstone {

/// What little walls seem to say along a corridor is noise of their normals. So patches that are
/// mostly seen by key scans that know nothing of a direction are turned to face across it, for all
/// that see them: the map can still be moved as a whole without any patch resisting. Of other
/// patches such key scans are no witnesses.
/// \param map_T_key  by key scan
/// \param open       key scans that left a direction to odometry, besides those whose surfaces here
///                   leave one open; empty: no others
void forget_open_directions(std::span<const PlacedKey> map_T_key, const std::vector<bool>& open,
                            SurfacePatches& patches);

}  // namespace loopstone
