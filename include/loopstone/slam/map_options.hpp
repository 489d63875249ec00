#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/surface_adjustment.hpp"

namespace loopstone {

/// Every option of the mapper. The defaults serve every log.
struct MapOptions {
  bool loop_closure = true;
  bool calibration = true;
  FrontEndOptions front_end{};
  GridMatchOptions match{};
  SubmapOptions submap{};
  LoopOptions loop{};
  SurfaceAdjustmentOptions adjustment{};
  OccupancyOptions map{};
  TextureOptions texture{};  ///< of the floor, when the log has RGB-D; not used by Mapper itself
};

template <typename Visitor>
void visit_options(MapOptions& options, Visitor&& visit) {
  visit("loop_closure", options.loop_closure, "recognise places seen before and correct the map");
  visit("calibration", options.calibration,
        "find out by the drive how the laser sits on the robot, and put right what is told wrong");
  visit.group("front_end", options.front_end);
  visit.group("match", options.match);
  visit.group("submap", options.submap);
  visit.group("loop", options.loop);
  visit.group("adjustment", options.adjustment);
  visit.group("map", options.map);
  visit.group("texture", options.texture);
}

}  // namespace loopstone
