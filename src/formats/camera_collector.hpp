#pragma once

#include <string>
#include <vector>

#include "formats/timing_collector.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/formats/picture_store.hpp"

namespace loopstone {

/// Gathers what a summary says of an RGB-D camera.
class CameraCollector {
 public:
  void add(const RgbdFrame& frame);
  /// Looks into the first picture of each kind for their sizes.
  /// \param pictures  of the log, if its frames are not files
  [[nodiscard]] CameraSummary finish(const PictureStore* pictures);

 private:
  CameraSummary summary_;
  TimingCollector frames_;
  TimingCollector depth_;
  TimingCollector colour_;
  std::vector<float> offsets_s_;
  RgbdFrame first_depth_;
  RgbdFrame first_colour_;
};

}  // namespace loopstone
