#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Places of the first that is a drive's, and behind its last.
struct DrivePart {
  std::size_t first = 0;
  std::size_t end = 0;
};

/// Of the file with the poses of one drive by its own clock, where there are several.
[[nodiscard]] inline std::string drive_trajectory_name(std::size_t drive) {
  return "trajectory_drive_" + std::to_string(drive + 1) + ".tum";
}

/// Of what is in the order of its stamps, by the map's clock.
template <typename Values, typename StampOf>
[[nodiscard]] DrivePart part_of_drive(const MapResult& result, std::size_t drive,
                                      const Values& values, StampOf&& stamp_of) {
  const auto place = [&](std::size_t of) -> std::size_t {
    if (of == 0) return 0;
    if (of > result.drives.size()) return values.size();
    const auto at = std::ranges::lower_bound(values, result.drives[of - 1].begins, {}, stamp_of);
    return static_cast<std::size_t>(at - values.begin());
  };
  return {place(drive), place(drive + 1)};
}

}  // namespace loopstone
