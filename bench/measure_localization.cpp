// Follows a robot through a simulated drive on a known map, and prints how that went as one JSON
// object:
//   measure_localization PLACE [key=value]...
// Keys: seed, duration_s, beams, people, clutter, kidnaps, map_seed, rough (0/1), random_start
// (0/1), start (truth | global | wrong), particles, sensor, trace (a file: one line a scan with the
// evidence and the error, for fitting the probability).

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "localization_runs.hpp"
#include "loopstone/localization/localizer.hpp"

namespace loopstone::bench {
namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

struct Arguments {
  RunRequest request;
  std::string start = "global";
  std::string trace;
  LocalizationOptions options;
};

Arguments parse(int argc, char** argv) {
  if (argc < 2) throw std::invalid_argument("usage: measure_localization PLACE [key=value]...");
  Arguments arguments;
  arguments.request.place = argv[1];
  for_each_setting(argc, argv, [&](const std::string& key, const std::string& value) {
    RunRequest& r = arguments.request;
    if (key == "seed")
      r.seed = std::stoull(value);
    else if (key == "duration_s")
      r.duration_s = std::stod(value);
    else if (key == "beams")
      r.beams = std::stoi(value);
    else if (key == "people")
      r.people = std::stoi(value);
    else if (key == "clutter")
      r.clutter = std::stoi(value);
    else if (key == "kidnaps")
      r.kidnaps = std::stoi(value);
    else if (key == "rough")
      r.rough = value == "1";
    else if (key == "map_seed")
      r.map_seed = std::stoull(value);
    else if (key == "random_start")
      r.random_start = value == "1";
    else if (key == "start")
      arguments.start = value;
    else if (key == "trace")
      arguments.trace = value;
    else if (key == "particles")
      arguments.options.particles_max = std::stoi(value);
    else if (key == "sensor")
      arguments.options.sensor = find_word<ScanModel>(value).value();
    else
      throw std::invalid_argument("unknown key: " + key);
  });
  return arguments;
}

std::optional<InitialPose> initial_pose(const std::string& start, const Run& run) {
  if (start == "global") return {};
  const Pose2& truth = run.truth.front().pose;
  if (start == "truth") return InitialPose{truth, 0.3, 0.2};
  if (start == "wrong") return InitialPose{truth * Pose2{3.0, 2.0, 1.0}, 0.3, 0.2};
  throw std::invalid_argument("start: truth, global or wrong, not " + start);
}

/// Between the last scan before a kidnapping and the first after it.
double carried_distance_m(const Trajectory& truth, Stamp first_after) {
  const auto& poses = truth.poses();
  const auto after = std::find_if(poses.begin(), poses.end(), [&](const StampedPose2& pose) {
    return pose.stamp >= first_after;
  });
  if (after == poses.begin() || after == poses.end()) return 0.0;
  return (after->pose.translation() - std::prev(after)->pose.translation()).norm();
}

int measure(const Arguments& arguments) {
  const Run run = make_run(arguments.request);
  const auto build_start = cpu_seconds();
  const LocalizationMap map(run.map);
  const double build_s = cpu_seconds() - build_start;
  Localizer localizer(map, run.robot, arguments.options, initial_pose(arguments.start, run),
                      arguments.request.seed, {1});
  const double start_s = cpu_seconds();
  // With the search, a scan takes so much longer than any other that the longest is the search and
  // its first weighing.
  double longest_scan_s = 0.0;
  for (const SensorMessage& message : run.messages) {
    const double before = cpu_seconds();
    localizer.add(message);
    longest_scan_s = std::max(longest_scan_s, cpu_seconds() - before);
  }
  const LocalizationResult result = localizer.finish();
  const double cpu_s = cpu_seconds() - start_s;

  double squares = 0.0;
  double squares_of_all = 0.0;
  double nees = 0.0;
  int tracking = 0;
  int lost = 0;
  int wrong_tracking = 0;
  int right_lost = 0;
  int right = 0;
  std::optional<double> first_tracking_m;
  std::optional<bool> first_tracking_right;
  std::vector<double> recovered_m;  // by kidnap; negative: not
  std::vector<double> carried_m;    // how far each took the robot
  std::size_t kidnap = 0;
  std::optional<double> carried_at_m;
  std::ofstream trace;
  if (!arguments.trace.empty()) trace.open(arguments.trace);
  for (const LocalizationEstimate& estimate : result.estimates) {
    const PoseError error = error_of(estimate, run);
    if (kidnap < run.kidnaps.size() && estimate.stamp >= run.kidnaps[kidnap]) {
      if (carried_at_m) recovered_m.push_back(-1.0);
      carried_at_m = estimate.travelled_m;
      carried_m.push_back(carried_distance_m(run.truth, run.kidnaps[kidnap]));
      ++kidnap;
    }
    const bool is_tracking = estimate.state == LocalizationState::kTracking;
    right += error.right() ? 1 : 0;
    squares_of_all += error.metres * error.metres;
    if (is_tracking) {
      ++tracking;
      if (!error.right()) ++wrong_tracking;
      if (!first_tracking_m) {
        first_tracking_m = estimate.travelled_m;
        first_tracking_right = error.right();
      }
      if (error.right()) {
        squares += error.metres * error.metres;
        const Pose2 truth = *run.truth.at_clamped(estimate.stamp);
        const Eigen::Vector3d off{estimate.map_T_robot.x - truth.x,
                                  estimate.map_T_robot.y - truth.y,
                                  wrap_angle(estimate.map_T_robot.yaw - truth.yaw)};
        nees += off.dot(estimate.covariance.inverse() * off) / 3.0;
      }
      if (carried_at_m && error.right()) {
        recovered_m.push_back(estimate.travelled_m - *carried_at_m);
        carried_at_m.reset();
      }
    }
    if (estimate.state == LocalizationState::kLost) {
      ++lost;
      if (error.right()) ++right_lost;
    }
    if (trace.is_open()) {
      const PoseEvidence& e = estimate.evidence;
      trace << fmt::format("{} {:.4f} {:.4f} {} {} {:.6f} {} {} {} {} {} {} {} {} {:.3f}",
                           error.right() ? 1 : 0, error.metres, error.radians, is_tracking ? 1 : 0,
                           estimate.state == LocalizationState::kLost ? 1 : 0, estimate.probability,
                           e.explained, e.violations, e.unexpected, e.mass, e.precision, e.spread_m,
                           e.spread_rad, e.innovation, estimate.travelled_m);
      trace << fmt::format(" {} {} {} {}", e.followed_m, e.known, e.silent, e.unproven);
      for (const FitOverWay& fit : {e.lately, e.along}) {
        trace << fmt::format(" {} {} {} {} {}", fit.explained, fit.violations, fit.unexpected,
                             fit.known, fit.silent);
      }
      trace << '\n';
    }
  }
  if (carried_at_m) recovered_m.push_back(-1.0);
  const auto scans = static_cast<double>(std::max<std::size_t>(1, result.estimates.size()));
  const int right_tracking = tracking - wrong_tracking;
  const PoseError last =
      result.estimates.empty() ? PoseError{1e9, 4.0} : error_of(result.estimates.back(), run);
  const auto list = [](const std::vector<double>& values) {
    std::string text;
    for (const double value : values)
      text += fmt::format("{}{:.3f}", text.empty() ? "" : ", ", value);
    return text;
  };
  fmt::print(
      "{{\"place\": \"{}\", \"seed\": {}, \"map_m2\": {:.0f}, \"scans\": {}, \"path_m\": {:.1f}, "
      "\"rmse_m\": {:.5f}, \"rmse_all_m\": {:.5f}, \"nees\": {:.3f}, \"right\": {:.4f}, "
      "\"tracking\": {:.4f}, \"lost\": "
      "{:.4f}, "
      "\"wrong_tracking\": {:.5f}, \"right_lost\": {:.5f}, \"first_tracking_m\": {}, "
      "\"first_tracking_right\": {}, \"last_right\": {}, \"last_tracking\": {}, \"recovered_m\": "
      "[{}], \"carried_m\": [{}], \"searches\": {}, \"longest_scan_s\": {:.4f}, "
      "\"search_s\": {:.4f}, \"filter_ms_per_scan\": {:.4f}, \"cpu_s\": {:.3f}, \"build_s\": "
      "{:.3f}, "
      "\"map_bytes\": {}, \"particles_last\": {}}}\n",
      arguments.request.place, arguments.request.seed, map.free_area_m2(), result.scans,
      result.path_length_m, right_tracking > 0 ? std::sqrt(squares / right_tracking) : -1.0,
      std::sqrt(squares_of_all / scans), right_tracking > 0 ? nees / right_tracking : -1.0,
      right / scans, tracking / scans, lost / scans, wrong_tracking / scans, right_lost / scans,
      first_tracking_m ? fmt::format("{:.3f}", *first_tracking_m) : "null",
      first_tracking_right ? (*first_tracking_right ? "true" : "false") : "null",
      last.right() ? "true" : "false",
      !result.estimates.empty() && result.estimates.back().state == LocalizationState::kTracking
          ? "true"
          : "false",
      list(recovered_m), list(carried_m), result.searches.size(), longest_scan_s, result.search_s,
      1e3 * result.filter_s / scans, cpu_s, build_s, map.memory_bytes(),
      result.estimates.empty() ? 0 : result.estimates.back().particles);
  return 0;
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  try {
    return loopstone::bench::measure(loopstone::bench::parse(argc, argv));
  } catch (const std::exception& error) {
    fmt::print(stderr, "measure_localization: {}\n", error.what());
    return 1;
  }
}
