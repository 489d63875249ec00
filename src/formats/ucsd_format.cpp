#include "formats/ucsd_format.hpp"

#include <filesystem>
#include <optional>

#include "formats/log_path.hpp"
#include "formats/ucsd_files.hpp"
#include "formats/ucsd_reader.hpp"
#include "formats/ucsd_writer.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

}  // namespace

Recognition recognise_ucsd(const LogInput& log) {
  const bool is_ours = log.is_folder ? !ucsd_sets(log.path).empty() : log.head.starts_with("PK");
  return is_ours ? Recognition::kCertain : Recognition::kNo;
}

std::unique_ptr<LogReader> open_ucsd(const LogInput& log, const LogOptions& options) {
  if (log.is_folder) return open_ucsd_log(log.path, log.set, options);
  const auto set = set_in_name(log.path.filename().string());
  if (!set) {
    throw DataError({log.path.string()},
                    "is an archive, but its name is not that of a sensor (EncodersN.npz, "
                    "HokuyoN.npz, ...)");
  }
  return open_ucsd_log(folder_of(log.path), set, options);
}

std::vector<std::string> ucsd_log_files(const LogInput& log) {
  std::optional<int> set = log.set;
  if (!log.is_folder) {
    set = set_in_name(log.path.filename().string());
    if (log.path.extension() != ".npz" || !set) return {};
  }
  const UcsdFiles files = find_ucsd_files(log.is_folder ? log.path : folder_of(log.path), set);
  std::vector<std::string> paths;
  for (const auto& part : {files.encoders, files.imu, files.hokuyo, files.kinect, files.odometry}) {
    if (part) paths.push_back(part->string());
  }
  return paths;
}

std::unique_ptr<LogWriter> create_ucsd(const LogTarget& target, const RobotModel& robot) {
  return create_ucsd_log(target.path, robot, target.set);
}

LogParts ucsd_parts(const LogTarget& target) {
  const fs::path folder(target.path);
  const std::string set = std::to_string(target.set);
  LogParts parts;
  for (const std::string_view sensor : kUcsdSensors) {
    parts.files.push_back((folder / (std::string(sensor) + set + ".npz")).string());
  }
  for (const char* const pictures : {"RGB", "Disparity", "Depth"}) {
    parts.folders.push_back((folder / "dataRGBD" / (pictures + set)).string());
  }
  return parts;
}

}  // namespace loopstone
