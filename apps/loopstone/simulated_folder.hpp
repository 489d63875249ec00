#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/simulation/simulate.hpp"

// The folder that `loopstone simulate` leaves: a log, its truth, the map.

namespace loopstone::app {

struct SimulatedFolder {
  std::filesystem::path path;
  const LogFormat* format = nullptr;
  bool has_pictures = false;

  /// The folder itself, or a file in it.
  [[nodiscard]] LogTarget log() const;
  /// The log as seen from the folder, so that it can be moved.
  [[nodiscard]] std::string log_name() const;
};

/// A drive, when it is over.
struct SimulatedDrive {
  SimulationSummary summary;
  Trajectory truth;
  std::vector<std::string> notes;  ///< of the log's writer
};

/// Drives and writes the log, pictures included.
[[nodiscard]] SimulatedDrive write_drive(const SimulatedFolder& folder, const World& world,
                                         const RobotModel& robot, const SimulationOptions& options,
                                         std::uint64_t seed, const AppContext& context);

/// truth.tum, map.yaml with its picture, the floor when it was seen.
void write_truth(const SimulatedFolder& folder, const World& world, const Trajectory& truth);

/// world.json: what was simulated, after what came of it.
/// \param result  the command's own result
/// \param record  of realism, if there was any
/// \param floor   that the user asked for
void write_description(const SimulatedFolder& folder, nlohmann::ordered_json result,
                       const RobotModel& robot, const SimulationOptions& options,
                       const RealismRecord& record, const std::optional<std::string>& floor);

/// An older simulation goes, its description first: whoever ends this run leaves no mixture of both
/// that looks whole.
void remove_simulation(const std::filesystem::path& folder);

}  // namespace loopstone::app
