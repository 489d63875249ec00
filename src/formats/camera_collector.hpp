#pragma once

#include <string>
#include <vector>

#include "formats/timing_collector.hpp"
#include "loopstone/formats/log_summary.hpp"

namespace loopstone {

/// Gathers what a summary says of an RGB-D camera.
class CameraCollector {
 public:
  void add(const RgbdFrame& frame);
  /// Looks into the first picture of each kind for their sizes.
  [[nodiscard]] CameraSummary finish();

 private:
  CameraSummary summary_;
  TimingCollector frames_;
  TimingCollector depth_;
  TimingCollector colour_;
  std::vector<float> offsets_s_;
  std::string first_depth_path_;
  std::string first_colour_path_;
};

}  // namespace loopstone
