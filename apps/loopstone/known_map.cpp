#include "known_map.hpp"

#include <filesystem>
#include <system_error>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/pipeline/site.hpp"

namespace loopstone::app {

namespace fs = std::filesystem;

std::string map_yaml_of(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? (fs::path(path) / "map.yaml").string() : path;
}

LocalizationMap read_known_map(const std::string& path, const MemoryBudget& budget,
                               Threads threads) {
  try {
    if (is_site(path)) {
      const Site site(path, SiteAccess::kRead, threads);
      return LocalizationMap(cell_states(site.map().result.map));
    }
  } catch (const UsageError& error) {
    throw DataError({path}, error.what());
  }
  const std::string yaml = map_yaml_of(path);
  std::error_code ignored;
  if (yaml != path && !fs::exists(yaml, ignored)) {
    throw DataError({path},
                    "there is no map.yaml in this folder; `loopstone map LOG -o FOLDER` leaves "
                    "one, and --map takes any map_server YAML file, and the file of a site");
  }
  try {
    return LocalizationMap(read_ros_map(yaml, budget, LocalizationMap::kBytesPerCell));
  } catch (const UsageError& error) {  // of the map itself: there is nothing to see on it
    throw DataError({yaml}, error.what());
  }
}

}  // namespace loopstone::app
