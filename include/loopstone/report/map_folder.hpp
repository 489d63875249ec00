#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/slam/loop_closure.hpp"

namespace loopstone {

/// A closure as loop_closures.csv has it; nothing of its stamps where the file has none.
struct StampedClosure {
  LoopClosure closure{};
  std::optional<Stamp> from{};
  std::optional<Stamp> to{};
};

/// A picture that lies on the map.
struct PlacedPicture {
  std::string png{};
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  ///< lower left [m]
  double resolution_m = 0.0;
};

/// What write_map_outputs() left in a folder, as far as it is there.
struct MapFolder {
  Trajectory trajectory{};
  std::vector<Eigen::Matrix3d> covariances{};  ///< one a pose, or none
  std::vector<StampedClosure> closures{};
  std::optional<CellStates> cells{};
  std::string summary_json{};              ///< whole; empty: there is none
  std::optional<PlacedPicture> quality{};  ///< the map's part of quality.png
  std::optional<PlacedPicture> texture{};
  std::vector<std::string> left_out{};  ///< why something that is there is not here, in words
};

/// Reads it again. What is missing is left out; what is there and damaged, too, and told. Throws
/// DataError when there is no trajectory.tum, or it can't be read.
[[nodiscard]] MapFolder read_map_folder(const std::string& folder, const MemoryBudget& budget = {});

/// The text of loop_closures.csv. Columns are found by their names. Throws DataError with the line.
[[nodiscard]] std::vector<StampedClosure> parse_closure_csv(
    std::string_view text, const std::string& path_for_errors = "loop_closures.csv");
/// The covariances of trajectory.csv by its stamps, in its order; those of `trajectory`. Throws
/// DataError with the line, and when it is of another path.
[[nodiscard]] std::vector<Eigen::Matrix3d> parse_covariance_csv(
    std::string_view text, const Trajectory& trajectory,
    const std::string& path_for_errors = "trajectory.csv");

}  // namespace loopstone
