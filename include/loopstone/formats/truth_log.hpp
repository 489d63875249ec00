#pragma once

#include <string>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// The robot's true poses that a log holds beside what its sensors measured: of a simulator, or of
/// a system that watched the robot from outside.
///
/// Stamps are those that the log's messages get with the same options, poses are of the robot in
/// the truth's own frame. Reads the log once from the beginning to the end; damaged records are
/// told to LogOptions::on_problem and passed over, or an error with LogOptions::strict.
/// \param log_path  as open_log() takes it
/// \param topic     of the poses: "TRUEPOS" in CARMEN text
/// Throws DataError when the log can't be read, its format has no true poses, or there are none
/// under this name; it says which there are. ReadingStopped.
[[nodiscard]] Trajectory read_truth(const std::string& log_path, const std::string& topic,
                                    const LogOptions& options = {});

}  // namespace loopstone
