#pragma once

#include <memory>

#include "loopstone/formats/ros_map.hpp"

namespace loopstone::python {

/// A map of cells in percent, as known ones are; can't be changed.
struct GridMap {
  std::shared_ptr<const CellStates> cells{};
};

}  // namespace loopstone::python
