#include "loopstone/formats/mrclam.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "formats/atomic_file.hpp"
#include "formats/log_path.hpp"
#include "formats/mrclam_line.hpp"
#include "formats/skip_tally.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// Subjects up to this are robots.
constexpr int kRobots = 5;
constexpr double kFastest = 100.0;  ///< [m/s] and [rad/s]
constexpr double kFarthestSightingM = 1000.0;
/// The robot does not go on at a speed that nobody told for longer [s].
constexpr double kLongestHoldS = 1.0;

/// Reads the lines of one file; what is wrong with one is counted or thrown.
class LineTaker {
 public:
  LineTaker(const std::string& path, const MrclamOptions& options, SkipTally& tally)
      : path_(path), options_(options), tally_(tally) {}

  /// \param take  a line's content; returns what is wrong with it, or nothing
  void read(std::string_view text, const std::function<std::string(std::string_view)>& take) {
    std::string first_fault;
    for_each_line(text, [&](std::string_view line, std::int64_t number) {
      const std::string_view content = without_comment(line);
      if (content.empty()) return;
      ++lines_;
      const std::string fault = take(content);
      if (fault.empty()) {
        ++taken_;
        return;
      }
      if (first_fault.empty()) first_fault = fmt::format("line {}: {}", number, fault);
      skip({path_, number}, fault);
    });
    if (taken_ > 0) return;
    throw DataError({path_}, lines_ == 0 ? "holds no line but comments"
                                         : "no line of it can be used; " + first_fault);
  }

 private:
  void skip(const Location& where, const std::string& fault) {
    if (options_.strict) throw DataError(where, fault);
    LogProblem problem;
    problem.location = where;
    problem.reason = fault;
    tally_.add(problem);
    if (options_.on_problem) options_.on_problem(problem);
  }

  std::string path_;
  const MrclamOptions& options_;
  SkipTally& tally_;
  std::int64_t lines_ = 0;
  std::int64_t taken_ = 0;
};

/// Speeds become poses.
class SpeedIntegrator {
 public:
  explicit SpeedIntegrator(std::vector<OdometryPose>& poses) : poses_(poses) {}

  std::string take(std::string_view content) {
    const auto line = timed_line<2>(content, "time, forward speed, yaw rate");
    if (!line.fault.empty()) return line.fault;
    if (std::abs(line.values[0]) > kFastest || std::abs(line.values[1]) > kFastest) {
      return "no robot is that fast";
    }
    Pose2 pose;
    if (!poses_.empty()) {
      const double since_s = (line.stamp - poses_.back().stamp).seconds();
      if (since_s <= 0.0) return "the time does not go on";
      const double held_s = std::min(since_s, kLongestHoldS);
      pose = poses_.back().odom_T_robot *
             exp(Tangent2(speed_m_s_ * held_s, 0.0, yaw_rate_rad_s_ * held_s));
    }
    poses_.push_back({line.stamp, pose});
    speed_m_s_ = line.values[0];
    yaw_rate_rad_s_ = line.values[1];
    return {};
  }

 private:
  std::vector<OdometryPose>& poses_;
  double speed_m_s_ = 0.0;
  double yaw_rate_rad_s_ = 0.0;
};

/// Sightings become readings.
class SightingTaker {
 public:
  SightingTaker(MrclamLog& log, const BarcodeTable& barcodes, const MrclamOptions& options)
      : log_(log), barcodes_(barcodes), options_(options) {}

  std::string take(std::string_view content) {
    const auto line = timed_line<3>(content, "time, barcode, range, bearing");
    if (!line.fault.empty()) return line.fault;
    const auto barcode = whole(line.values[0]);
    const auto subject = barcode ? barcodes_.subject_of(*barcode) : std::nullopt;
    if (!subject) return "a barcode that nobody carries by Barcodes.dat";
    const double range = line.values[1];
    if (!(range > 0.0 && range <= kFarthestSightingM)) return "the range must be 0 to 1000 m";
    if (std::abs(line.values[2]) > 2.0 * kPi) return "the bearing must be in radians";
    if (!log_.readings.empty() && line.stamp < log_.readings.back().stamp)
      return "the time goes back";
    if (*subject <= kRobots) {
      ++log_.of_robots;
      return {};
    }
    if (log_.readings.empty() || log_.readings.back().stamp != line.stamp)
      log_.readings.push_back({.stamp = line.stamp});
    LandmarkObservation seen =
        observed(range, line.values[2], options_.range_sigma_m, options_.bearing_sigma_rad);
    seen.id = *subject;
    log_.readings.back().observations.push_back(std::move(seen));
    return {};
  }

 private:
  MrclamLog& log_;
  const BarcodeTable& barcodes_;
  const MrclamOptions& options_;
};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

fs::path file_of(const fs::path& folder, int robot, const char* kind) {
  return folder / fmt::format("Robot{}_{}.dat", robot, kind);
}

bool has_drive(const fs::path& folder, int robot) {
  return is_file(file_of(folder, robot, "Odometry")) &&
         is_file(file_of(folder, robot, "Measurement"));
}

std::optional<int> first_robot(const fs::path& folder) {
  for (int robot = 1; robot <= kRobots; ++robot) {
    if (has_drive(folder, robot)) return robot;
  }
  return std::nullopt;
}

/// Which robot of a folder a log's name means.
int robot_of(const LogPath& log) {
  const auto first = first_robot(log.path);
  const int robot = log.set.value_or(first.value_or(1));
  if (!has_drive(log.path, robot)) {
    throw UsageError(fmt::format("{}: there is no {} with its measurements in this folder",
                                 log.path.string(), file_of({}, robot, "Odometry").string()));
  }
  return robot;
}

std::string text_of(const fs::path& path, const MemoryBudget& budget) {
  return read_whole_file(path.string(), budget.most_text_bytes());
}

}  // namespace

MrclamLog parse_mrclam_log(std::string_view odometry, const std::string& odometry_path,
                           std::string_view measurement, const std::string& measurement_path,
                           const BarcodeTable& barcodes, const MrclamOptions& options) {
  MrclamLog log;
  SkipTally tally;
  SpeedIntegrator integrator(log.odometry);
  LineTaker(odometry_path, options, tally).read(odometry, [&](std::string_view content) {
    return integrator.take(content);
  });
  SightingTaker sightings(log, barcodes, options);
  LineTaker(measurement_path, options, tally).read(measurement, [&](std::string_view content) {
    return sightings.take(content);
  });
  log.skipped = tally.skipped();
  return log;
}

bool is_mrclam_log(const std::string& log) {
  const LogPath path = split_set(log);
  return first_robot(path.path).has_value();
}

std::vector<std::string> mrclam_log_files(const std::string& log) {
  const LogPath path = split_set(log);
  const int robot = robot_of(path);
  return {file_of(path.path, robot, "Odometry").string(),
          file_of(path.path, robot, "Measurement").string(),
          (path.path / kMrclamBarcodes).string()};
}

MrclamLog read_mrclam_log(const std::string& log, const MrclamOptions& options,
                          const MemoryBudget& budget) {
  const std::vector<std::string> files = mrclam_log_files(log);
  const BarcodeTable barcodes = parse_barcodes(text_of(files[2], budget), files[2]);
  MrclamLog read = parse_mrclam_log(text_of(files[0], budget), files[0], text_of(files[1], budget),
                                    files[1], barcodes, options);
  read.robot = robot_of(split_set(log));
  return read;
}

}  // namespace loopstone
