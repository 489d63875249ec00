#pragma once

#include <cstdint>

#include "app.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/sensor/messages.hpp"
#include "progress_display.hpp"
#include "result.hpp"

// What `map` and `texture` share: from the frames of a log to the colour of the floor.

namespace loopstone::app {

/// The frames of a log's RGB-D camera; only their names are kept.
class CameraFrames {
 public:
  void take(const SensorMessage& message);
  [[nodiscard]] const std::vector<RgbdFrame>& frames() const { return frames_; }
  /// Those with depth and colour.
  [[nodiscard]] std::int64_t complete() const { return complete_; }

 private:
  std::vector<RgbdFrame> frames_{};
  std::int64_t complete_ = 0;
};

/// --cloud: cubes of 2 cm unless the options say otherwise.
void gather_cloud(TextureOptions& options);

[[nodiscard]] FloorTexture colour_floor(const CameraFrames& camera, const Trajectory& trajectory,
                                        const RobotModel& robot, const TextureOptions& options,
                                        const AppContext& context, ProgressDisplay& display);

/// What a person wants to know of it.
void add_texture_rows(const FloorTexture& texture, Result& table);

}  // namespace loopstone::app
