#include "formats/recording_formats.hpp"

#include <filesystem>
#include <optional>

#include "formats/byte_source.hpp"
#include "formats/mcap_stream.hpp"
#include "formats/recording.hpp"
#include "formats/recording_writer.hpp"
#include "formats/topic_log.hpp"
#include "formats/topic_log_writer.hpp"

namespace loopstone {
namespace {

using Open = std::unique_ptr<Recording> (*)(const std::string&, const RecordingOptions&);

OpenRecording opener(Open open, const std::string& path) {
  return [open, path](const RecordingOptions& options) { return open(path, options); };
}
OpenRecording opener(Open open, const LogInput& log) { return opener(open, log.path.string()); }

/// Who names the file beside the databases means all of them.
bool is_metadata(const LogInput& log) { return log.path.filename() == "metadata.yaml"; }

std::string rosbag2_place(const LogInput& log) {
  if (!is_metadata(log)) return log.path.string();
  const std::filesystem::path folder = log.path.parent_path();
  return folder.empty() ? "." : folder.string();
}

Recognition by_head(const LogInput& log, bool (*is_it)(std::string_view)) {
  return !log.is_folder && is_it(log.head) ? Recognition::kCertain : Recognition::kNo;
}

std::unique_ptr<LogReader> stream_mcap_log(const LogInput& log, const LogOptions& options) {
  const std::optional<double> look_s =
      options.live ? std::optional(options.live->look_s) : std::optional<double>();
  return open_streamed_log(
      "mcap",
      [log, look_s](const RecordingOptions& recording) {
        return stream_mcap(log.content->read(), log.name, recording, look_s);
      },
      options);
}

}  // namespace

Recognition recognise_bag(const LogInput& log) { return by_head(log, is_bag); }
std::unique_ptr<LogReader> open_bag_log(const LogInput& log, const LogOptions& options) {
  return open_topic_log("bag", opener(open_bag, log), options);
}
std::unique_ptr<LogWriter> create_bag_log(const LogTarget& target, const RobotModel& robot) {
  return create_topic_log(target, create_bag(target.path), robot);
}
Trajectory bag_truth(const LogInput& log, const std::string& topic, const LogOptions& options) {
  return read_topic_truth(log.name, topic, opener(open_bag, log), options);
}

Recognition recognise_mcap(const LogInput& log) { return by_head(log, is_mcap); }
std::unique_ptr<LogReader> open_mcap_log(const LogInput& log, const LogOptions& options) {
  if (log.is_stream) return stream_mcap_log(log, options);
  return open_topic_log("mcap", opener(open_mcap, log), options);
}
std::unique_ptr<LogWriter> create_mcap_log(const LogTarget& target, const RobotModel& robot) {
  return create_topic_log(target, create_mcap(target.path), robot);
}
Trajectory mcap_truth(const LogInput& log, const std::string& topic, const LogOptions& options) {
  return read_topic_truth(log.name, topic, opener(open_mcap, log), options);
}

Recognition recognise_rosbag2(const LogInput& log) {
  const auto is_packed_database = [&] { return log.name.ends_with(".db3.zstd"); };
  if (!log.is_folder && !is_metadata(log)) {
    return is_packed_database() ? Recognition::kCertain : by_head(log, is_sqlite);
  }
  return rosbag2_files(rosbag2_place(log)).empty() ? Recognition::kNo : Recognition::kCertain;
}
std::unique_ptr<LogReader> open_rosbag2_log(const LogInput& log, const LogOptions& options) {
  return open_topic_log("rosbag2", opener(open_rosbag2, rosbag2_place(log)), options);
}
std::vector<std::string> rosbag2_log_files(const LogInput& log) {
  const bool is_whole = log.is_folder || is_metadata(log);
  return is_whole ? rosbag2_files(rosbag2_place(log)) : std::vector<std::string>{};
}
std::unique_ptr<LogWriter> create_rosbag2_log(const LogTarget& target, const RobotModel& robot) {
  return create_topic_log(target, create_rosbag2(target.path), robot);
}
LogParts rosbag2_parts(const LogTarget& target) {
  const std::filesystem::path folder = std::filesystem::path(target.path).lexically_normal();
  const std::string name =
      folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  return {.files = {(folder / (name + "_0.db3")).string(), (folder / "metadata.yaml").string()}};
}
Trajectory rosbag2_truth(const LogInput& log, const std::string& topic, const LogOptions& options) {
  return read_topic_truth(log.name, topic, opener(open_rosbag2, rosbag2_place(log)), options);
}

}  // namespace loopstone
