#include "registration/align_plane.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/icp_guess.hpp"
#include "loopstone/registration/surface_cells.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "registration/align_clouds.hpp"

namespace loopstone {

namespace {

using Points = std::vector<Eigen::Vector2d>;

/// How wide a window is when only its other half is given.
constexpr double kDefaultSearchXyM = 1.0;
constexpr double kDefaultSearchYawRad = 0.35;
/// match_scans searches no farther.
constexpr double kScansSearchXyM = 2.0;

/// What is to be done.
struct Task {
  const PlaneSides& sides;
  const AlignRequest<2>& request;
  const AlignOptions<2>& options;

  [[nodiscard]] SearchWindow window(const Pose2& centre) const {
    return {centre, request.search_xy_m.value_or(kDefaultSearchXyM),
            request.search_yaw_rad.value_or(kDefaultSearchYawRad)};
  }
  [[nodiscard]] Pose2 first_guess() const {
    if (!request.from_centroids) return request.guess.value_or(Pose2{});
    return initial_guess<2>(IcpGuess::kCentroids, sides.source, sides.target);
  }
};

ScanView view_of(const RobotScan& scan) {
  BeamTable beams;
  return view_scan(scan.scan, scan.robot_T_lidar, scan.velocity, beams);
}

/// Scan against scan: a coarse search about the guess, then Gauss-Newton.
void match_two_scans(AlignResult<2>& result, const Task& task) {
  ScanMatchOptions options = task.options.scans;
  const AlignRequest<2>& request = task.request;
  if (request.anywhere) {
    options.search_half_xy_m = kScansSearchXyM;
    options.search_half_yaw_rad = kPi;
  }
  if (request.searches()) {
    options.search_half_xy_m = request.search_xy_m.value_or(options.search_half_xy_m);
    options.search_half_yaw_rad = request.search_yaw_rad.value_or(options.search_half_yaw_rad);
  }
  const ScanView source = view_of(*task.sides.source_scan);
  const ScanView target = view_of(*task.sides.target_scan);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_scans(source, target, guess, options);
  };
  match_from_starts<2>(result, request, {task.first_guess()}, matcher);
  result.method = "scans";
}

/// Scan against the surfaces of a scan on grids.
void match_on_surfaces(AlignResult<2>& result, const Task& task) {
  constexpr double kResolutionsM[] = {0.1, 0.2, 0.4};
  BeamTable beams;
  const auto surfaces = [&beams](const RobotScan& scan) {
    return surface_points(scan.scan, scan.robot_T_lidar, scan.velocity, SurfaceOptions{}, beams);
  };
  SurfaceGrid grid(kResolutionsM);
  grid.insert(surfaces(*task.sides.target_scan), Pose2{});
  const std::vector<SurfacePoint> source = surfaces(*task.sides.source_scan);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_to_grid(source, grid, guess, {}, task.options.grid, grid.level_count() - 1);
  };
  match_from_starts<2>(result, task.request, {task.first_guess()}, matcher);
  result.method = "grid";
}

/// Gauss-Newton on the distances to a map's walls.
void match_on_field(AlignResult<2>& result, const Task& task) {
  const MapField field(*task.sides.map, task.options.map.field);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_to_field(task.sides.source, field, guess, task.options.field);
  };
  match_from_starts<2>(result, task.request, {task.first_guess()}, matcher);
  result.method = "grid";
}

/// A best pose that others rival is no answer: the status says so.
MatchStatus status_of(const MapMatch& found, const MapMatchOptions& options) {
  if (!found.found()) return MatchStatus::kNotConverged;
  const MatchResult& best = found.poses.front();
  if (found.sure) return best.status;
  const bool rivalled =
      found.poses.size() > 1 && best.score - found.poses[1].score <= options.sure_gap;
  return rivalled && best.score >= options.sure_score ? MatchStatus::kDegenerate
                                                      : MatchStatus::kNotConverged;
}

/// Branch and bound over a window of a map, or all of it.
void search_map(AlignResult<2>& result, const Task& task) {
  // The search wants the laser's frame; everybody else the robot's.
  const RobotScan* scan = task.sides.source_scan;
  const Pose2 robot_T_lidar = scan != nullptr ? scan->robot_T_lidar : Pose2{};
  const Pose2 lidar_T_robot = robot_T_lidar.inverse();
  Points points;
  for (const Eigen::Vector2d& point : task.sides.source) points.push_back(lidar_T_robot * point);

  result.guess = task.first_guess();
  result.method = to_string(AlignMethod::kCorrelative);
  const bool anywhere = task.request.anywhere || (!task.request.guess && !task.request.searches());
  std::optional<SearchWindow> window;
  if (!anywhere) window = task.window(result.guess * robot_T_lidar);
  const MapSearch search(*task.sides.map, task.options.map);
  MapMatch found = match_on_map(points, search, window, task.options.map_match);
  for (MatchResult& match : found.poses) {
    const PoseWithCovariance2 map_T_robot =
        compound({match.target_T_source, match.covariance}, {lidar_T_robot});
    match.target_T_source = map_T_robot.pose;
    match.covariance = map_T_robot.covariance;
  }
  result.match = found.found() ? found.poses.front() : MatchResult{.target_T_source = result.guess};
  result.match.status = status_of(found, task.options.map_match);
  result.map_match = std::move(found);
}

/// So many at most, evenly chosen.
Points thinned(const Points& points) {
  constexpr std::size_t kMostPoints = 400;
  Points some;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kMostPoints);
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

/// Branch and bound over a window of a scan or cloud, then refinement.
void search_points(AlignResult<2>& result, const Task& task) {
  constexpr double kScanCellM = 0.05;
  constexpr double kCellShare = 0.01;  // of the target's radius
  constexpr double kLeastCellM = 1e-6;
  constexpr int kLevels = 7;
  constexpr double kMinScore = 0.2;
  const PlaneSides& sides = task.sides;
  result.guess = task.first_guess();
  result.method = to_string(AlignMethod::kCorrelative);
  if (sides.source.empty() || sides.target.empty()) {
    result.match = {.target_T_source = result.guess, .status = MatchStatus::kTooFewPairs};
    return;
  }
  const CloudExtent<2> target = cloud_extent<2>(sides.target);
  const double cell_m =
      sides.both_scans() ? kScanCellM : std::max(kCellShare * target.radius_m, kLeastCellM);
  const MaxPyramid pyramid(surface_cells(sides.target, cell_m, 2.0 * cell_m), kLevels, kUnknown);
  SearchWindow window = task.window(result.guess);
  if (task.request.anywhere) window = {window.centre, 2.0 * target.radius_m, kPi};
  const SearchResult found =
      search_branch_and_bound(thinned(sides.source), pyramid, window, kMinScore);
  if (!found.found) {
    result.match = {.target_T_source = result.guess};
  } else if (sides.both_scans()) {
    ScanMatchOptions options = task.options.scans;
    options.search_half_xy_m = options.search_half_yaw_rad = 0.0;
    result.match = match_scans(view_of(*sides.source_scan), view_of(*sides.target_scan),
                               found.target_T_source, options);
  } else {
    result.match = match_icp(sides.source, make_icp_cloud<2>(sides.target, task.options.icp_cloud),
                             found.target_T_source, task.options.icp);
  }
}

void refuse(bool wrong, const std::string& reason) {
  if (wrong) throw UsageError(reason);
}

void check(const Task& task) {
  const AlignRequest<2>& request = task.request;
  const AlignMethod method = request.method;
  const bool icp = method != AlignMethod::kAuto && method != AlignMethod::kCorrelative &&
                   method != AlignMethod::kGrid;
  refuse(icp && request.searches(),
         "a search window (search-xy, search-yaw) goes with the methods correlative and auto; " +
             std::string(to_string(method)) + " converges from its guess");
  refuse(request.sweep_yaw > 0 && (method == AlignMethod::kCorrelative || request.anywhere),
         "a sweep of headings (sweep-yaw) tries many starts, and a search needs none: leave one of "
         "them out");
  refuse(method == AlignMethod::kGrid && task.sides.map == nullptr && !task.sides.both_scans(),
         "the method grid aligns a scan to a scan or a map; use icp_line or icp_plane for clouds");
  refuse(method == AlignMethod::kGrid && (request.anywhere || request.searches()),
         "the method grid converges from its guess; leave it out to search");
}

/// ICP, or a search of clouds.
void match_points(AlignResult<2>& result, const Task& task) {
  align_clouds<2>(result, task.sides.source, task.sides.target, task.request, task.options);
}

/// What suits the sides and the request.
using Step = void (*)(AlignResult<2>&, const Task&);

Step step_on_map(const AlignRequest<2>& request) {
  const bool automatic = request.method == AlignMethod::kAuto;
  const bool known = request.is_guessed() || request.sweep_yaw > 0;
  if (request.anywhere || request.method == AlignMethod::kCorrelative) return search_map;
  if (automatic && (request.searches() || !known)) return search_map;
  return automatic || request.method == AlignMethod::kGrid ? match_on_field : match_points;
}

Step step_between_scans(const AlignRequest<2>& request) {
  const bool far = request.search_xy_m.value_or(0.0) > kScansSearchXyM;
  if (far || request.method == AlignMethod::kCorrelative) return search_points;
  if (request.method == AlignMethod::kAuto) return match_two_scans;
  return request.method == AlignMethod::kGrid ? match_on_surfaces : match_points;
}

Step step_between_points(const AlignRequest<2>& request) {
  const bool window = request.method == AlignMethod::kAuto && request.searches();
  return window || request.method == AlignMethod::kCorrelative ? search_points : match_points;
}

}  // namespace

AlignResult<2> align_plane(const PlaneSides& sides, const AlignRequest<2>& request,
                           const AlignOptions<2>& options) {
  const Task task{sides, request, options};
  check(task);
  AlignResult<2> result;
  result.source = cloud_extent<2>(sides.source);
  const Step step = sides.map != nullptr ? step_on_map(request)
                    : sides.both_scans() ? step_between_scans(request)
                                         : step_between_points(request);
  step(result, task);
  return result;
}

}  // namespace loopstone
