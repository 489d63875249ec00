#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/log_reader.hpp"
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
  /// What the log tells of them once it was read.
  void take_pictures(const LogReader& log);
  [[nodiscard]] const std::vector<RgbdFrame>& frames() const { return frames_; }
  /// Those with depth and colour.
  [[nodiscard]] std::int64_t complete() const { return complete_; }

  [[nodiscard]] const std::shared_ptr<const PictureStore>& pictures() const { return pictures_; }
  /// LogReader::camera_fault().
  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  std::vector<RgbdFrame> frames_{};
  std::shared_ptr<const PictureStore> pictures_{};
  std::string fault_{};
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
