#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "formats/carmen_line.hpp"
#include "formats/carmen_survey.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

struct BeamAngles {
  double angle_min_rad = 0.0;
  double angle_increment_rad = 0.0;
};

/// Where the beams of a FLASER or RLASER point; the line does not say. CARMEN's own rule
/// (carmen_laser_guess_*) goes by the number of beams: 181 at 1 deg, 180 at 1 deg (-90..+89, the
/// last beam left out), 361 and 360 at 0.5 deg, 401 and 400 at 0.25 deg about the middle, anything
/// else 180 deg evenly. The log's PARAM laser_front_laser_resolution beats it when it can be true
/// for that many beams.
[[nodiscard]] BeamAngles carmen_beam_angles(std::size_t beams, const CarmenSurvey& survey,
                                            int lidar);

/// A scan as the library wants it: angles, limits, +inf for no return, NaN for bad beams, the
/// mount. 0, negative and not finite ranges are bad, and so is what lies beyond 1 km: no planar
/// scanner measures that.
[[nodiscard]] LaserScan to_laser_scan(CarmenScan&& scan, Stamp stamp, const CarmenSurvey& survey);

/// The name of the PARAM line that says how far ahead a laser is mounted; of the first two lasers.
[[nodiscard]] std::optional<std::string> carmen_offset_param(int lidar);

/// What the log's PARAM line says of how far ahead a laser is mounted; nothing when it says nothing
/// that can be.
[[nodiscard]] std::optional<double> carmen_laser_offset(const CarmenSurvey& survey, int lidar);

/// robot_T_lidar by the log's poses or its PARAM lines; nothing when it says nothing.
[[nodiscard]] std::optional<Pose2> carmen_mount(const CarmenSurvey& survey, int lidar);

}  // namespace loopstone
