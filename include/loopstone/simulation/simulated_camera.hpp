#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// What makes depths uncertain. The defaults are a Kinect's of the first kind (Khoshelham and
/// Elberink 2012, "Accuracy and resolution of Kinect depth data").
struct SimulatedDepth {
  double noise_steps = 0.7;
  double dropout_probability = 0.003;
  double grazing_dropout = 1.0;
  double projector_baseline_m = 0.075;
};

/// What makes colours uncertain.
struct SimulatedColour {
  double exposure_s = 0.006;
  double gain_wander = 0.04;
  double vignetting = 0.06;
  double noise_levels = 1.5;
  double lag_s = 0.013;
};

/// An RGB-D camera on a robot, and how it differs from what the robot's file says. The default
/// mount errors are what a bracket bent by hand has.
struct SimulatedCamera {
  double rate_hz = 5.0;
  double clock_offset_s = 0.0;
  double pitch_error_rad = 0.0175;
  double roll_error_rad = 0.005;
  double height_error_m = 0.004;
  SimulatedDepth depth{};
  SimulatedColour colour{};
};

template <typename Visitor>
void visit_options(SimulatedDepth& options, Visitor&& visit) {
  visit("noise_steps", options.noise_steps, Range{0.0, 100.0},
        "standard deviation in steps of the Kinect's disparity");
  visit("dropout_probability", options.dropout_probability, Range{0.0, 1.0},
        "share of pixels without depth for no visible reason");
  visit("grazing_dropout", options.grazing_dropout, Range{0.0, 1.0},
        "and of those that see a surface edge-on; none from 6 deg on");
  visit("projector_baseline_m", options.projector_baseline_m, Range{0.0, 1.0},
        "what its light can't reach has no depth; 0: no shadows");
}

template <typename Visitor>
void visit_options(SimulatedColour& options, Visitor&& visit) {
  visit("exposure_s", options.exposure_s, Range{0.0, 0.1}, "smears the floor along its motion");
  visit("gain_wander", options.gain_wander, Range{0.0, 1.0},
        "automatic exposure: standard deviation of log brightness");
  visit("vignetting", options.vignetting, Range{0.0, 0.9},
        "how much darker the corners are, share");
  visit("noise_levels", options.noise_levels, Range{0.0, 100.0},
        "standard deviation of a channel, of 255");
  visit("lag_s", options.lag_s, Range{-0.5, 0.5},
        "colour is taken this much after depth, and stamped so");
}

template <typename Visitor>
void visit_options(SimulatedCamera& options, Visitor&& visit) {
  visit("rate_hz", options.rate_hz, Range{0.1, 60.0}, "frames a second");
  visit("clock_offset_s", options.clock_offset_s, Range{-1.0, 1.0},
        "the camera's stamps are this late");
  visit("pitch_error_rad", options.pitch_error_rad, Range{-0.5, 0.5},
        "it looks this much farther down than the robot's file says");
  visit("roll_error_rad", options.roll_error_rad, Range{-0.5, 0.5},
        "and leans this much to the right");
  visit("height_error_m", options.height_error_m, Range{-0.5, 0.5}, "and sits this much higher");
  visit.group("depth", options.depth);
  visit.group("colour", options.colour);
}

/// The camera as it truly is: the model with the mount errors in it. Roll, pitch and yaw are those
/// of Pose3::from_roll_pitch_yaw; the errors add to them.
[[nodiscard]] CameraModel true_camera(const CameraModel& model, const SimulatedCamera& options);

}  // namespace loopstone
