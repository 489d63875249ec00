#pragma once

#include "loopstone/mapping/floor_texture.hpp"
#include "report/output_files.hpp"

namespace loopstone {

/// texture.png with its world file and texture.yaml, coverage.png; cloud.ply when points were
/// gathered. Nothing when no floor was seen.
void add_texture_files(const FloorTexture& texture, FileSet& files);

}  // namespace loopstone
