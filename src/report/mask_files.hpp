#pragma once

#include <string>

#include "loopstone/formats/ros_map.hpp"

namespace loopstone {

/// NAME.pgm and NAME.yaml, by map_server's mode raw: values as they are, 255 where nothing is
/// known. Both are complete on disk before the first appears. Throws DataError.
/// \param values  0 to 100, or kUnknownCell
void write_mask(const CellStates& values, const std::string& folder, const std::string& name);

/// Makes a folder where it is missing. Throws DataError.
void make_folder(const std::string& folder);

}  // namespace loopstone
