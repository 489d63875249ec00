#pragma once

#include "loopstone/mapping/floor_texture.hpp"
#include "mapping/texture_cell.hpp"

namespace loopstone {

/// Turns what was gathered into the colours, frame and areas of `texture`, small gaps filled.
/// \param gain  all light is multiplied by it
void finish_texture(const TileGrid<TextureCell>& gathered, const TextureOptions& options,
                    double gain, FloorTexture& texture);

}  // namespace loopstone
