#pragma once

#include <memory>
#include <string>

#include "formats/recording.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/odometry/trajectory.hpp"

// Logs that are recordings of topics: what their messages mean.

namespace loopstone {

/// What it takes to open a recording: the options are for it to keep.
using OpenRecording = std::function<std::unique_ptr<Recording>(const RecordingOptions& options)>;

/// \param format  the name of the container in the table of formats
/// Throws what opening throws, UsageError for topics that the user named and that are not there.
[[nodiscard]] std::unique_ptr<LogReader> open_topic_log(const std::string& format,
                                                        const OpenRecording& open,
                                                        const LogOptions& options);

/// True poses out of a recording: of a topic with poses, or "tf:FRAME", the robot's pose in that
/// frame of tf. As read_truth().
[[nodiscard]] Trajectory read_topic_truth(const std::string& name, const std::string& topic,
                                          const OpenRecording& open, const LogOptions& options);

}  // namespace loopstone
