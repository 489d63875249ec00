#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/plan/extract_plan.hpp"
#include "loopstone/report/plan_outputs.hpp"

namespace loopstone {

namespace {

namespace fs = std::filesystem;

/// Bytes of a cell while a plan is drawn: labels, barriers, what was seen.
constexpr std::uint64_t kBytesPerCell = 16;

/// Those that the map was drawn from, as far as the state has them still.
std::vector<const MappedScan*> scans_of(const Session& session) {
  std::vector<const MappedScan*> scans;
  for (const SubmapRecord& submap : session.mapper.back_end.chain.submaps)
    submap.scans.for_each([&](const MappedScan& scan) { scans.push_back(&scan); });
  for (const WaitingScan& waiting : session.mapper.waiting)
    if (waiting.scan) scans.push_back(waiting.scan.get());
  return scans;
}

/// Where the mount was corrected after the last scan, the trajectory is of another centre than the
/// state's scans (correct_mount() of the mapper). Identity where summary.json tells of none.
Pose2 robot_T_told(const fs::path& folder, const MemoryBudget& budget) {
  std::error_code ignored;
  const fs::path path = folder / "summary.json";
  if (!fs::is_regular_file(path, ignored)) return {};
  const nlohmann::json summary = nlohmann::json::parse(
      read_whole_file(path.string(), budget.most_text_bytes()), nullptr, false);
  try {
    const nlohmann::json& found = summary.at("calibration");
    if (!found.at("mount_corrected").get<bool>()) return {};
    const nlohmann::json& lidar = found.at("lidar");
    const auto value = [&](const char* key, const char* which) {
      return lidar.at(key).at(which).get<double>();
    };
    const Pose2 given{value("x_m", "given"), value("y_m", "given"), value("yaw_rad", "given")};
    Pose2 corrected = given;
    if (lidar.at("yaw_is_off").get<bool>()) corrected.yaw = value("yaw_rad", "value");
    if (lidar.at("place_is_off").get<bool>()) {
      corrected.x = value("x_m", "value");
      corrected.y = value("y_m", "value");
    }
    return corrected * given.inverse();
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

/// Nothing where the folder has no state, or its trajectory is of another run.
WallSamples measured_samples(const fs::path& folder, const CellStates& cells,
                             const MemoryBudget& budget, Threads threads) {
  std::error_code ignored;
  const fs::path trajectory = folder / "trajectory.tum";
  if (!fs::exists(kept_state_path(folder.string()), ignored) || !fs::exists(trajectory, ignored))
    return {};
  const Session session = read_kept_state(folder.string(), "draw a plan from", budget);
  return samples_of_scans(scans_of(session), read_tum(trajectory.string(), budget), cells, threads,
                          robot_T_told(folder, budget));
}

VectorPlan plan_of_site(const std::string& path, Threads threads) {
  const SiteMap site = Site(path, SiteAccess::kRead, threads).map({}, {.scans = true});
  try {
    return plan_of(site.result, site.scans, walls_of(site.edits), threads);
  } catch (const UsageError& error) {
    throw DataError({path}, error.what());
  }
}

/// Through the cells, where there is nothing better.
VectorPlan plan_through(WallSamples samples, const CellStates& cells) {
  if (samples.samples.empty()) samples = samples_of_cells(cells);
  return extract_plan(cells, samples);
}

CellStates cells_of(const MapResult& map) {
  if (!map.map_failure.empty()) throw UsageError(map.map_failure);
  return cell_states(map.map);
}

}  // namespace

VectorPlan read_plan(const std::string& path, const MemoryBudget& budget, Threads threads) {
  if (is_site(path)) return plan_of_site(path, threads);
  std::error_code ignored;
  const bool is_folder = fs::is_directory(path, ignored);
  const std::string yaml = is_folder ? (fs::path(path) / "map.yaml").string() : path;
  if (is_folder && !fs::exists(yaml, ignored)) {
    throw DataError({path},
                    "there is no map.yaml in this folder; `loopstone map LOG -o FOLDER` leaves "
                    "one, and any map_server YAML file will do");
  }
  const CellStates cells = read_ros_map(yaml, budget, kBytesPerCell);
  WallSamples samples;
  if (is_folder) samples = measured_samples(path, cells, budget, threads);
  try {
    return plan_through(std::move(samples), cells);
  } catch (const UsageError& error) {
    throw DataError({yaml}, error.what());
  }
}

VectorPlan plan_of(const MapResult& map, const Session* state, Threads threads) {
  const CellStates cells = cells_of(map);
  WallSamples samples;
  if (state != nullptr && !map.trajectory.empty()) {
    const Calibration& found = map.calibration;
    const Pose2 robot_T_told =
        found.is_corrected ? found.robot_T_lidar() * found.robot_T_lidar_given.inverse() : Pose2{};
    // As the file has it, to nine digits: the same bytes.
    samples = samples_of_scans(scans_of(*state), parse_tum(format_tum(map.trajectory)), cells,
                               threads, robot_T_told);
  }
  return plan_through(std::move(samples), cells);
}

VectorPlan plan_of(const MapResult& map, const MappedScans& scans, std::span<const Polygon2> walls,
                   Threads threads) {
  const CellStates cells = cells_of(map);
  std::vector<const MappedScan*> all;
  for (const auto& scan : scans) all.push_back(scan.get());
  WallSamples samples = samples_of_scans(all, map.trajectory, cells, threads);
  if (!samples.samples.empty()) add_walls(walls, cells, samples);
  return plan_through(std::move(samples), cells);
}

std::string plan_name(const std::string& path) {
  const fs::path plain = fs::path(path).lexically_normal();
  return plain.filename().empty() ? plain.parent_path().filename().string() : plain.stem().string();
}

}  // namespace loopstone
