#include "formats/ucsd_files.hpp"

#include <set>
#include <string_view>

#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// The data folder itself, or where copies of the course's files keep the sensors inside it.
std::vector<fs::path> sensor_folders(const fs::path& folder) {
  return {folder, folder / "sensors", folder / "data"};
}

std::optional<int> set_of(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const std::string_view sensor : kUcsdSensors) {
    if (!name.starts_with(sensor) || !name.ends_with(".npz")) continue;
    const auto digits =
        std::string_view(name).substr(sensor.size(), name.size() - sensor.size() - 4);
    const auto number = parse_integer(digits);
    if (number && *number >= 0 && *number <= 1'000'000) return static_cast<int>(*number);
  }
  return std::nullopt;
}

std::optional<fs::path> first_existing(const std::vector<fs::path>& candidates) {
  std::error_code ignored;
  for (const fs::path& candidate : candidates) {
    if (fs::exists(candidate, ignored)) return candidate;
  }
  return std::nullopt;
}

std::optional<fs::path> find_sensor(const fs::path& folder, std::string_view sensor, int set) {
  std::vector<fs::path> candidates;
  const std::string name = std::string(sensor) + std::to_string(set) + ".npz";
  for (const fs::path& place : sensor_folders(folder)) candidates.push_back(place / name);
  return first_existing(candidates);
}

std::optional<fs::path> find_images(const fs::path& folder, const std::string& name) {
  return first_existing({folder / "dataRGBD" / name, folder / "data" / "dataRGBD" / name,
                         folder / name, folder.parent_path() / "dataRGBD" / name});
}

std::string listed(const std::vector<int>& sets) {
  std::string text;
  for (const int set : sets) text += (text.empty() ? "" : ", ") + std::to_string(set);
  return text;
}

}  // namespace

std::vector<int> ucsd_sets(const fs::path& folder) {
  std::set<int> sets;
  std::error_code ignored;
  for (const fs::path& place : sensor_folders(folder)) {
    for (const auto& entry : fs::directory_iterator(place, ignored)) {
      if (const auto set = set_of(entry.path())) sets.insert(*set);
    }
  }
  return {sets.begin(), sets.end()};
}

bool holds_disparity(const UcsdFiles& files) {
  return files.disparity_folder || !files.depth_folder;
}

UcsdFiles find_ucsd_files(const fs::path& folder, std::optional<int> set) {
  const std::vector<int> sets = ucsd_sets(folder);
  if (sets.empty()) {
    throw DataError({folder.string()}, "the folder holds no file of a sensor of the UCSD layout");
  }
  if (!set && sets.size() > 1) {
    throw UsageError(folder.string() + " holds several sets (" + listed(sets) +
                     "): name one, for example " + folder.string() + "#" +
                     std::to_string(sets.front()));
  }
  UcsdFiles files;
  files.folder = folder;
  files.set = set.value_or(sets.front());
  files.encoders = find_sensor(folder, "Encoders", files.set);
  files.imu = find_sensor(folder, "Imu", files.set);
  files.hokuyo = find_sensor(folder, "Hokuyo", files.set);
  files.kinect = find_sensor(folder, "Kinect", files.set);
  files.odometry = find_sensor(folder, "Odometry", files.set);
  if (!files.encoders && !files.imu && !files.hokuyo && !files.kinect && !files.odometry) {
    throw UsageError(folder.string() + " holds no set " + std::to_string(files.set) +
                     "; it holds " + listed(sets));
  }
  const std::string number = std::to_string(files.set);
  files.colour_folder = find_images(folder, "RGB" + number);
  files.disparity_folder = find_images(folder, "Disparity" + number);
  files.depth_folder = find_images(folder, "Depth" + number);
  return files;
}

}  // namespace loopstone
