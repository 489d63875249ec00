#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/sensor/messages.hpp"

// The UTIAS multi-robot cooperative localization and mapping dataset: five robots among fifteen
// landmarks with barcodes. Text, words between blanks, # begins a comment.
//
//   Barcodes.dat               subject barcode        subjects 1 to 5 are robots, others landmarks
//   Landmark_Groundtruth.dat   subject x y sigma_x sigma_y             [m]
//   RobotN_Odometry.dat        time forward_speed yaw_rate             [s, m/s, rad/s]
//   RobotN_Measurement.dat     time barcode range bearing              [s, m, rad]
//   RobotN_Groundtruth.dat     time x y heading                        [s, m, rad]
//
// Source: Leung, Halpern, Barfoot and Liu 2011, "The UTIAS multi-robot cooperative localization and
// mapping dataset".

namespace loopstone {

inline constexpr const char* kMrclamLandmarks = "Landmark_Groundtruth.dat";
inline constexpr const char* kMrclamBarcodes = "Barcodes.dat";

/// Which landmark carries which barcode.
struct BarcodeTable {
  std::map<int, int> subjects{};  ///< by barcode

  /// The subject of a barcode; nothing: none has it.
  [[nodiscard]] std::optional<int> subject_of(int barcode) const;
};

/// One robot's drive.
struct MrclamLog {
  /// Dead reckoning: the speeds of each line held until the next. odom_T_robot, from the origin on.
  std::vector<OdometryPose> odometry{};
  /// Barcodes of landmarks, by their subjects' numbers. Lines of one time are one reading.
  std::vector<LandmarkReading> readings{};
  std::int64_t of_robots = 0;  ///< sightings of other robots, which are left out
  SkippedRecords skipped{};    ///< broken or out of order, or barcodes that nobody carries
  int robot = 1;
};

/// Throws DataError with the line for anything that is no barcode table.
[[nodiscard]] BarcodeTable parse_barcodes(std::string_view text,
                                          const std::string& path_for_errors);

/// Landmarks by their subjects' numbers; sigma_m is the larger of both axes. Throws DataError with
/// the line.
[[nodiscard]] std::vector<MappedLandmark> parse_mrclam_landmarks(
    std::string_view text, const std::string& path_for_errors);

/// How the lines of a drive are read.
struct MrclamOptions {
  double range_sigma_m = 0.15;
  double bearing_sigma_rad = 0.04;
  bool strict = false;  ///< a broken line is an error instead of being counted and skipped
  std::function<void(const LogProblem&)> on_problem{};  ///< may be empty
};

/// A drive from its files' texts; the names are for messages. Throws DataError when no line of
/// either can be used.
[[nodiscard]] MrclamLog parse_mrclam_log(std::string_view odometry,
                                         const std::string& odometry_path,
                                         std::string_view measurement,
                                         const std::string& measurement_path,
                                         const BarcodeTable& barcodes,
                                         const MrclamOptions& options);

/// Poses of RobotN_Groundtruth.dat: map_T_robot. Throws DataError with the line.
[[nodiscard]] Trajectory parse_mrclam_truth(std::string_view text,
                                            const std::string& path_for_errors);

/// Whether a log's name, "DIR" or "DIR#2", is of a folder with RobotN_Odometry.dat and
/// RobotN_Measurement.dat.
[[nodiscard]] bool is_mrclam_log(const std::string& log);
/// The files that read_mrclam_log reads. Throws UsageError when the robot asked for is not there.
[[nodiscard]] std::vector<std::string> mrclam_log_files(const std::string& log);

/// Robot N of "DIR#N"; without a number the first that is there. Throws DataError that names file
/// and line, UsageError when that robot is not there.
[[nodiscard]] MrclamLog read_mrclam_log(const std::string& log, const MrclamOptions& options,
                                        const MemoryBudget& budget = {});
[[nodiscard]] std::vector<MappedLandmark> read_mrclam_landmarks(const std::string& folder,
                                                                const MemoryBudget& budget = {});
/// Whether a file's name is that of a RobotN_Groundtruth.dat.
[[nodiscard]] bool is_mrclam_truth(const std::string& path);
[[nodiscard]] Trajectory read_mrclam_truth(const std::string& path,
                                           const MemoryBudget& budget = {});

}  // namespace loopstone
